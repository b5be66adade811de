// SPDX-License-Identifier: Apache-2.0
// Functions of mmcs_sim.h called from another process: arguments in, results out, as bytes.
//
// A number is 8 bytes, an array or a structure its length in 8 bytes and then itself, or -1 and
// nothing for NULL. An answer is the result, then every array as it is now, or -1 for one that the
// function may not write; one that it only points to (const T **) is as long as the result says.
#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "mcdef.h"
#include "mmcs_service.h"
#include "mmcs_sim.h"

namespace mmcs {

// What stays here, and is no argument: one machine and one script.
struct Kept {
  mmcs_sim *sim = nullptr;
  mmcs_script *script = nullptr;
};

class Reader {
 public:
  explicit Reader(const std::vector<char> &bytes) : bytes_(bytes) {}
  template <class T>
  T number() {
    using Sent = std::conditional_t<std::is_floating_point_v<T>, double, int64_t>;
    Sent value;
    std::memcpy(&value, take(sizeof value), sizeof value);
    return static_cast<T>(value);
  }
  // False: NULL.
  bool array(std::vector<char> &into) {
    const auto length = number<int64_t>();
    if (length < 0) return false;
    const char *from = take(static_cast<size_t>(length));
    into.assign(from, from + length);
    return true;
  }

 private:
  const char *take(size_t n) {
    if (n > bytes_.size() - at_) throw std::runtime_error("a call that is cut short");
    at_ += n;
    return bytes_.data() + at_ - n;
  }
  const std::vector<char> &bytes_;
  size_t at_ = 0;
};

class Writer {
 public:
  template <class T>
  void number(T value) {
    using Sent = std::conditional_t<std::is_floating_point_v<T>, double, int64_t>;
    const Sent sent = static_cast<Sent>(value);
    append(&sent, sizeof sent);
  }
  void array(const void *from, size_t length) {
    number(static_cast<int64_t>(length));
    append(from, length);
  }
  const std::vector<char> &bytes() const { return bytes_; }

 private:
  void append(const void *from, size_t length) {
    const auto *bytes = static_cast<const char *>(from);
    bytes_.insert(bytes_.end(), bytes, bytes + length);
  }
  std::vector<char> bytes_;
};

// An argument by its type: a number, the machine, an array, or a pointer to an array.
template <class T>
struct Argument {
  T value;
  Argument(Reader &in, const Kept &) : value(in.number<T>()) {}
  T get() { return value; }
  void answer(Writer &, int64_t) {}
};
template <class T>
struct Argument<T *> {
  static constexpr size_t kSize = sizeof(std::conditional_t<std::is_void_v<T>, char, T>);
  std::vector<char> bytes;
  bool given;
  Argument(Reader &in, const Kept &) : given(in.array(bytes)) {
    if (bytes.size() % kSize) throw std::runtime_error("a call with another structure");
  }
  T *get() { return given ? reinterpret_cast<T *>(bytes.data()) : nullptr; }
  void answer(Writer &out, int64_t) {
    if (std::is_const_v<T> || !given) return out.number(-1);
    out.array(bytes.data(), bytes.size());
  }
};
template <class T>
struct Argument<const T **> {
  const T *found = nullptr;
  Argument(Reader &, const Kept &) {}
  const T **get() { return &found; }
  void answer(Writer &out, int64_t count) {
    out.array(found, found && count > 0 ? static_cast<size_t>(count) * sizeof(T) : 0);
  }
};
template <>
struct Argument<mmcs_sim *> {
  mmcs_sim *sim;
  Argument(Reader &, const Kept &kept) : sim(kept.sim) {}
  mmcs_sim *get() { return sim; }
  void answer(Writer &, int64_t) {}
};
template <>
struct Argument<const mmcs_sim *> : Argument<mmcs_sim *> {
  using Argument<mmcs_sim *>::Argument;
};
template <>
struct Argument<mmcs_script *> {
  mmcs_script *script;
  Argument(Reader &, const Kept &kept) : script(kept.script) {}
  mmcs_script *get() { return script; }
  void answer(Writer &, int64_t) {}
};
template <>
struct Argument<const mmcs_script *> : Argument<mmcs_script *> {
  using Argument<mmcs_script *>::Argument;
};

using Call = std::function<void(const Kept &, Reader &, Writer &)>;

template <class R, class... A>
Call make_call(R (*function)(A...)) {
  return [function]([[maybe_unused]] const Kept &kept, [[maybe_unused]] Reader &in, Writer &out) {
    std::tuple<Argument<A>...> arguments{Argument<A>(in, kept)...};
    std::apply(
        [&](auto &...a) {
          int64_t count = 0;
          if constexpr (std::is_void_v<R>) {
            function(a.get()...);
          } else if constexpr (std::is_same_v<R, const char *>) {
            const char *text = function(a.get()...);
            out.array(text, text ? std::strlen(text) + 1 : 0);
          } else {
            const R result = function(a.get()...);
            out.number(result);
            count = static_cast<int64_t>(result);
          }
          (a.answer(out, count), ...);
        },
        arguments);
  };
}

}  // namespace mmcs
