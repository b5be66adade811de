// SPDX-License-Identifier: Apache-2.0
// What ESLint says of the project's JavaScript. Names that nobody declares are found by tsc.

const RULES = ["array-callback-return", "consistent-return", "constructor-super",
  "default-case-last", "eqeqeq", "for-direction", "getter-return", "no-async-promise-executor",
  "no-class-assign", "no-cond-assign", "no-const-assign", "no-constant-condition",
  "no-constructor-return", "no-dupe-args", "no-dupe-class-members", "no-dupe-else-if",
  "no-dupe-keys", "no-duplicate-case", "no-duplicate-imports", "no-else-return", "no-empty",
  "no-empty-pattern", "no-eval", "no-ex-assign", "no-extra-boolean-cast", "no-fallthrough",
  "no-func-assign", "no-implied-eval", "no-import-assign", "no-lonely-if", "no-loop-func",
  "no-loss-of-precision", "no-new-wrappers", "no-prototype-builtins", "no-redeclare",
  "no-self-assign", "no-self-compare", "no-setter-return", "no-shadow",
  "no-shadow-restricted-names", "no-sparse-arrays", "no-template-curly-in-string",
  "no-this-before-super", "no-throw-literal", "no-unmodified-loop-condition", "no-unneeded-ternary",
  "no-unreachable", "no-unreachable-loop", "no-unsafe-finally", "no-unsafe-negation",
  "no-unsafe-optional-chaining", "no-unused-expressions", "no-unused-private-class-members",
  "no-useless-catch", "no-useless-concat", "no-useless-escape", "no-useless-rename",
  "no-useless-return", "no-var", "object-shorthand", "prefer-const", "prefer-object-spread",
  "prefer-promise-reject-errors", "prefer-rest-params", "prefer-template", "require-yield",
  "use-isnan", "valid-typeof"];
export default [{
  rules: { ...Object.fromEntries(RULES.map(name => [name, "error"])),
    "no-unused-vars": ["error", { argsIgnorePattern: "^_", varsIgnorePattern: "^_",
      ignoreRestSiblings: true }] },
}];
