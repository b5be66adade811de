// SPDX-License-Identifier: Apache-2.0
// A request of the messages and its arguments, checked for every carrier; what a reply says, as
// JSON.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

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

// --- what the reply says: JSON ---

using Fields = std::vector<std::pair<std::string, std::string>>;

std::string printed(const char *format, double value) {
  char text[400];
  std::snprintf(text, sizeof text, format, value);
  return text;
}
std::string whole(double value) {
  return printed("%.0f", value);
}
std::string real(double value) {
  const std::string text = printed("%.17g", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}
std::string quoted(const std::string &text) {
  std::string out = "\"";
  for (char c : text) {
    if (static_cast<unsigned char>(c) < ' ') {
      char code[8];
      std::snprintf(code, sizeof code, "\\u%04x", c);
      out += code;
      continue;
    }
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}
std::string joined(char open, const std::vector<std::string> &parts, char close) {
  std::string out(1, open);
  for (const std::string &part : parts) out += (out.size() > 1 ? "," : "") + part;
  return out + close;
}
std::string object(const Fields &fields) {
  std::vector<std::string> parts;
  for (const auto &[key, value] : fields) parts.push_back(quoted(key) + ":" + value);
  return joined('{', parts, '}');
}
struct Made {
  std::string text;  // JSON
};
template <class T>
std::string json(const T &value) {
  if constexpr (std::is_same_v<T, Made>)
    return value.text;
  else if constexpr (std::is_same_v<T, bool>)
    return value ? "true" : "false";
  else if constexpr (std::is_integral_v<T>)
    return std::to_string(value);
  else if constexpr (std::is_floating_point_v<T>)
    return real(value);
  else
    return quoted(value);
}
// Of keys and values by turns.
Fields fields() {
  return {};
}
template <class T, class... More>
Fields fields(const char *key, const T &value, const More &...more) {
  Fields made = {{key, json(value)}};
  for (auto &one : fields(more...)) made.push_back(std::move(one));
  return made;
}
// The ints of a structure, with their names or without.
std::string wholes(const void *data, size_t count, const char *const *names = nullptr) {
  std::vector<int> values(count);
  std::memcpy(values.data(), data, count * sizeof(int));
  std::vector<std::string> parts;
  parts.reserve(count);
  for (size_t n = 0; n < count; ++n)
    parts.push_back((names ? quoted(names[n]) + ":" : "") + std::to_string(values[n]));
  return names ? joined('{', parts, '}') : joined('[', parts, ']');
}

// --- what is asked ---

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
