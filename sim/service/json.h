// SPDX-License-Identifier: Apache-2.0
// What is told to a carrier, as JSON.
#pragma once

#include <cstdio>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace {

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
template <class T>
std::string json(const std::vector<T> &list) {
  std::vector<std::string> parts;
  parts.reserve(list.size());
  for (const T &one : list) parts.push_back(json(one));
  return joined('[', parts, ']');
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

}  // namespace
