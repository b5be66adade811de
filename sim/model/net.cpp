// SPDX-License-Identifier: Apache-2.0
// Variables of a model by name: Verilator's table of scopes.

#include "board.h"

#include "verilated_sym_props.h"

namespace mmcs {

Net find_net(const VerilatedContext &context, const std::string &scope, const std::string &name) {
  const VerilatedScope *s = context.scopeFind(scope.c_str());
  const VerilatedVar *v = s ? s->varFind(name.c_str()) : nullptr;
  if (!v) return {};
  Net net;
  net.at = static_cast<char *>(v->datap());
  net.bytes = static_cast<int>(v->totalSize());
  net.width = static_cast<int>(v->entBits());
  net.entry = static_cast<int>(v->entSize());
  return net;
}

}  // namespace mmcs
