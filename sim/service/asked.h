// SPDX-License-Identifier: Apache-2.0
// A request of the messages and its arguments, checked for every carrier.
#pragma once

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "json.h"
#include "mcdef.h"

namespace {

constexpr int kRefusedValue = 22, kNoOp = 38;  // errno
constexpr size_t kFieldCount = sizeof(mc_param) / sizeof(int);
// clang-format off
// generated: fields of mcdef.h
constexpr const char *kState[] = {"adcvai", "encnow", "inow", "error", "fbnow", "vel", "errcode"};
constexpr const char *kParam[] = {"which", "a2", "a1", "a0", "b2", "b1", "b0", "ic_pos", "ic_neg",
    "mode", "clkdivisor", "ilim", "ilimax", "plo", "phi", "adc_a", "adc_b", "ipole"};
constexpr const char *kStats[] = {"total", "missed", "overrun", "panics", "spurious", "clips"};
// end of fields
// clang-format on
static_assert(sizeof kParam / sizeof *kParam == kFieldCount, "mcdef.h has changed: make generate");

struct Refusal : std::runtime_error {
  Refusal(int number, const std::string &text) : std::runtime_error(text), error(number) {}
  int error;  // an errno
};

struct Value {
  char kind = 0;  // of mmcs_server_request()
  std::string text;
  std::vector<std::pair<std::string, Value>> of;
  double number() const { return std::strtod(text.c_str(), nullptr); }
  bool fits() const { return kind == 'i' && number() >= -2147483648. && number() <= 2147483647; }
};

enum class Kind { kOp, kWhole, kNumber, kFlag, kText, kWholes, kFields };
struct Argument {
  const char *op, *name;
  Kind kind;
  double low = 0, high = 0;
  double otherwise = NAN;  // NaN: it must be there; or OPTIONAL
  std::string choices = "";
};

constexpr double OPTIONAL = INFINITY;

std::vector<Argument> table(double AXES) {
  const double LAST_AXIS = AXES - 1;
  return {
#define OP(op) {#op, "", Kind::kOp},
#define WHOLE(op, name, ...) {#op, #name, Kind::kWhole, __VA_ARGS__},
#define NUMBER(op, name, ...) {#op, #name, Kind::kNumber, __VA_ARGS__},
#define FLAG(op, name, ...) {#op, #name, Kind::kFlag, __VA_ARGS__},
#define TEXT(op, name, choices) {#op, #name, Kind::kText, 0, 0, NAN, choices},
#define WHOLES(op, name, most) {#op, #name, Kind::kWholes, 0, most},
#define PARAM(op, name, ...) {#op, #name, Kind::kFields, 0, 0, __VA_ARGS__},
#include "messages.def"
  };
}

class Asked {
 public:
  Asked(const char *flat, double axes) : table_(table(axes)) {
    std::istringstream lines(flat);
    for (std::string line; std::getline(lines, line);) {
      const size_t first = line.find('\t'), last = line.rfind('\t');
      Value &top = said_[line.substr(0, first)];
      if (first != last) top.of.emplace_back(line.substr(first + 1, last - first - 1), Value{});
      Value &value = first == last ? top : top.of.back().second;
      value.kind = line[last + 1];
      value.text = line.substr(last + 2);
    }
    op_ = get({"", "op", Kind::kText}).text;
    if (!find("")) throw Refusal(kNoOp, "op: there is no '" + op_ + "'");
  }

  const std::string &op() const { return op_; }
  bool has(const std::string &name) const { return said_.count(name) != 0; }

  const Value &get(const std::string &name) { return get(*find(name)); }
  const Value &get(const Argument &is) {
    const std::string name = is.name;
    if (!has(name) && std::isfinite(is.otherwise))
      said_[name] = {is.kind == Kind::kFlag ? 'b' : 'i', whole(is.otherwise), {}};
    const Value &value = said_[name];
    const bool number = value.kind == 'i' || value.kind == 'd';
    bool good = number && is.low <= value.number() && value.number() <= is.high;
    std::string what;
    switch (is.kind) {
      case Kind::kOp:
        break;
      case Kind::kWhole:
        good = good && value.kind == 'i';
        what = "a whole number from " + whole(is.low) + " to " + whole(is.high);
        break;
      case Kind::kNumber:
        good = good || (value.kind == 'n' && is.otherwise == OPTIONAL);
        what = "a number from " + printed("%g", is.low) + " to " + printed("%g", is.high);
        break;
      case Kind::kFlag:
        good = value.kind == 'b';
        what = "true or false";
        break;
      case Kind::kText:
        what = is.choices.empty() ? "a text" : is.choices;
        good = value.kind == 't' && (is.choices.empty() ||
                                     (" " + what + " ").find(" " + value.text + " ") < what.size());
        break;
      case Kind::kWholes:
        what = "at most " + whole(is.high) + " whole numbers of 32 bits";
        good = value.kind == 'l' && static_cast<double>(value.of.size()) <= is.high;
        for (const auto &[_, one] : value.of) good = good && one.fits();
        break;
      case Kind::kFields:
        what = "an object with fields of struct mc_param";
        good = value.kind == 'o' && !value.of.empty();
        for (const auto &[field, one] : value.of) {
          if (!good || (word(field) < kFieldCount && one.fits())) continue;
          good = false;
          what = field + " is no field, or not a number of 32 bits";
        }
    }
    if (!good) throw Refusal(kRefusedValue, name + ": " + what);
    return value;
  }

  // All of this op that there are, for the carrier to do it.
  Fields checked() {
    Fields out;
    for (const Argument &is : table_) {
      if (op_ != is.op || is.kind == Kind::kOp || (is.otherwise == OPTIONAL && !has(is.name)))
        continue;
      const Value &value = get(is);
      Fields fields;
      for (const auto &[field, one] : value.of) fields.emplace_back(field, one.text);
      out.emplace_back(is.name, is.kind == Kind::kText     ? quoted(value.text)
                                : value.kind == 'n'        ? "null"
                                : value.kind == 'b'        ? (value.text == "1" ? "true" : "false")
                                : is.kind == Kind::kNumber ? real(value.number())
                                : value.kind == 'o'        ? object(fields)
                                                           : value.text);
    }
    return out;
  }

  void change(mc_param &param) {
    for (const auto &[field, one] : get("param").of) {
      const int value = static_cast<int>(one.number());
      if (field != "which")
        std::memcpy(reinterpret_cast<char *>(&param) + word(field) * sizeof value, &value,
                    sizeof value);
    }
  }

 private:
  static size_t word(const std::string &field) {
    size_t n = 0;
    while (n < kFieldCount && field != kParam[n]) ++n;
    return n;
  }
  const Argument *find(const std::string &name) const {
    for (const Argument &is : table_)
      if (op_ == is.op && name == is.name) return &is;
    return nullptr;
  }
  std::vector<Argument> table_;
  std::map<std::string, Value> said_;
  std::string op_;
};

}  // namespace
