// SPDX-License-Identifier: Apache-2.0
// Bytes out and bytes in, by one list of members per class: `a(x)` writes or reads x.
//
// A class names what changes in it once, in `template <class A> void state(A &a)`, so that saving
// and restoring cannot drift apart. Bytes are for this build on this kind of machine only.
#pragma once

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <type_traits>
#include <vector>

namespace mmcs {

using Bytes = std::vector<uint8_t>;

// Whether each byte belongs to a member: padding holds anything, and digests are made of what is
// written. A struct with floating-point members says so beside its use.
template <typename T>
inline constexpr bool kFull = !std::is_class_v<T> || std::has_unique_object_representations_v<T>;

class Writer {
 public:
  static constexpr bool kReads = false;
  static constexpr bool kFutureOnly = false;
  template <typename T>
  void operator()(const T &value) {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    static_assert(kFull<T>);
    raw(&value, sizeof value);
  }
  template <typename T>
  void operator()(const std::vector<T> &values) {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    static_assert(kFull<T>);
    (*this)(static_cast<uint64_t>(values.size()));
    raw(values.data(), values.size() * sizeof(T));
  }
  // One whose length the machine gives.
  template <typename T>
  void same(const std::vector<T> &values) {
    (*this)(values);
  }
  void raw(const void *data, size_t size) {
    const uint8_t *from = static_cast<const uint8_t *>(data);
    out_.insert(out_.end(), from, from + size);
  }
  Bytes take() { return std::move(out_); }

 private:
  Bytes out_;
};

// Writes what decides the future, and nothing that only tells of the past: two runs of which it
// makes the same bytes are the same from there on.
class FutureWriter : public Writer {
 public:
  static constexpr bool kFutureOnly = true;
};

// A member that tells of the past: counts, running hashes, what has been noted.
template <class A, typename T>
void past(A &a, T &value) {
  if constexpr (!A::kFutureOnly) a(value);
}

// Throws std::invalid_argument when the bytes end too early, or are those of another machine.
class Reader {
 public:
  static constexpr bool kReads = true;
  static constexpr bool kFutureOnly = false;
  Reader(const uint8_t *data, size_t size) : at_(data), end_(data + size) {}
  template <typename T>
  void operator()(T &value) {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    raw(&value, sizeof value);
  }
  template <typename T>
  void operator()(std::vector<T> &values) {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    uint64_t count = 0;
    (*this)(count);
    if (count > static_cast<uint64_t>(end_ - at_) / sizeof(T)) cut();
    values.resize(count);
    raw(values.data(), values.size() * sizeof(T));
  }
  template <typename T>
  void same(std::vector<T> &values) {
    const size_t count = values.size();
    (*this)(values);
    expect(values.size() == count);
  }
  void operator()(bool &value) {
    uint8_t byte = 0;
    raw(&byte, 1);
    expect(byte <= 1);
    value = byte != 0;
  }
  // Things that follow, of at least so many bytes each.
  void count(size_t &count, size_t bytes) {
    (*this)(count);
    if (count > static_cast<size_t>(end_ - at_) / bytes) cut();
  }
  static void expect(bool possible) {
    if (!possible) throw std::invalid_argument("the snapshot is of another machine");
  }
  void raw(void *data, size_t size) {
    if (size > static_cast<size_t>(end_ - at_)) cut();
    if (size) std::memcpy(data, at_, size);
    at_ += size;
  }
  bool done() const { return at_ == end_; }

 private:
  [[noreturn]] static void cut() { throw std::invalid_argument("the snapshot is cut short"); }
  const uint8_t *at_;
  const uint8_t *end_;
};

}  // namespace mmcs
