// SPDX-License-Identifier: Apache-2.0
// Verilator's save and restore, into memory instead of a file.
#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

#include "verilated_save.h"

namespace mmcs {

class MemorySave final : public VerilatedSerialize {
 public:
  MemorySave() { m_isOpen = true; }
  ~MemorySave() override { m_isOpen = false; }
  void flush() override {
    out_.insert(out_.end(), m_bufp, m_cp);
    m_cp = m_bufp;
  }
  void put(const void *data, size_t size) { write(data, size); }
  std::vector<uint8_t> take() {
    flush();
    return std::move(out_);
  }

 private:
  std::vector<uint8_t> out_;
};

class MemoryRestore final : public VerilatedDeserialize {
 public:
  explicit MemoryRestore(const std::vector<uint8_t> &in) : in_(in) {
    m_isOpen = true;
    m_endp = m_bufp;
  }
  ~MemoryRestore() override { m_isOpen = false; }
  // Keeps what was not consumed and tops the buffer up.
  void fill() override {
    const size_t rest = static_cast<size_t>(m_endp - m_cp);
    std::memmove(m_bufp, m_cp, rest);
    const size_t more = std::min(bufferSize() - rest, in_.size() - at_);
    std::memcpy(m_bufp + rest, in_.data() + at_, more);
    at_ += more;
    m_cp = m_bufp;
    m_endp = m_bufp + rest + more;
  }
  void get(void *data, size_t size) { read(data, size); }

 private:
  const std::vector<uint8_t> &in_;
  size_t at_ = 0;
};

}  // namespace mmcs
