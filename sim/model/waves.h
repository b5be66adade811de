// SPDX-License-Identifier: Apache-2.0
// A file of waveforms. Where it could not be written, Verilator's writer aborts the process when
// the file is closed: the file is half, and removed.

#pragma once

#include <unistd.h>

#include <csignal>
#include <string>

#include "own_card.h"
#include "verilated_fst_c.h"

namespace mmcs {

class Waves : public VerilatedFstC {
 public:
  explicit Waves(const std::string &path) : path_(path) {}
  ~Waves() override {
    closing_ = path_.c_str();
    const auto before = std::signal(SIGABRT, end_unwritten);
    close();
    std::signal(SIGABRT, before);
  }

  // The registers of own cards, whose model is in a library of its own, in a scope beside the top.
  void add(const OwnCard &card) {
    card_ = &card;
    spTrace()->addInitCb(declare, this, "CARD", false, static_cast<uint32_t>(2 * card.size()));
    spTrace()->addFullCb(put<&Buffer::fullQData>, 0, this);
    spTrace()->addChgCb(put<&Buffer::chgQData>, 0, this);
  }

 private:
  using Buffer = VerilatedFst::Buffer;

  // A register has two codes of 32 bits; the path before its name is scopes.
  static void declare(void *self, VerilatedFst *to, uint32_t code) {
    static_cast<Waves *>(self)->code_ = code;
    const OwnCard &card = *static_cast<Waves *>(self)->card_;
    for (size_t reg = 0; reg < card.size(); ++reg, code += 2) {
      std::string name = "CARD." + card.name(reg);
      int scopes = 0;
      for (size_t dot; (dot = name.find('.')) != std::string::npos; name.erase(0, dot + 1)) {
        to->pushPrefix(name.substr(0, dot).c_str(), VerilatedTracePrefixType::SCOPE_MODULE);
        ++scopes;
      }
      to->declQuad(code, name.c_str(), -1, VerilatedTraceSigDirection::NONE,
                   VerilatedTraceSigKind::VAR, VerilatedTraceSigType::LOGIC, card.width(reg) - 1,
                   0);
      while (scopes-- > 0) to->popPrefix();
    }
  }
  template <void (Buffer::*emit)(uint32_t *, QData, int)>
  static void put(void *self, Buffer *to) {
    uint32_t *at = to->oldp(static_cast<Waves *>(self)->code_);
    const OwnCard &card = *static_cast<Waves *>(self)->card_;
    for (size_t reg = 0; reg < card.size(); ++reg, at += 2) {
      (to->*emit)(at, card.read(reg), card.width(reg));
    }
  }
  static void end_unwritten(int) {
    static const char text[] =
        "mmcs: aborted where waveforms are written: if the disk is full, free it and run again\n";
    unlink(closing_);
    _exit(write(STDERR_FILENO, text, sizeof text - 1) < 0 ? 2 : 1);
  }

  static inline const char *closing_;
  const std::string path_;
  const OwnCard *card_ = nullptr;
  uint32_t code_ = 0;  // of its first register
};

}  // namespace mmcs
