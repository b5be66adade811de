// SPDX-License-Identifier: Apache-2.0
// Which bits of data the glue passes on (cycle.h).

#include <vector>

#include "cycle.h"
#include "cycle_words.h"

namespace mmcs {

// inputs: of each wire that it reads its value, and of data which bits are to be followed. Each of
// these gets a pattern of its own over so many evaluations.
const std::vector<Rack::Cycles::GlueBit> &Rack::Cycles::glue(const std::vector<uint32_t> &inputs,
                                                             size_t data) {
  constexpr int kEvaluations = 64;
  std::vector<GlueBit> &found = glue_[inputs];
  if (!found.empty()) return found;
  std::vector<uint64_t> patterns, outputs;
  uint64_t random = 1;
  for (size_t n = 0; n < data; ++n) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    patterns.push_back(random ^ random >> 31);
  }
  for (int n = 0; n < kEvaluations; ++n) {
    auto input = inputs.begin();
    auto pattern = patterns.begin();
    for (const Wire *w : rack_.glue_wires_) {
      uint32_t value = *input++;
      for (uint32_t bits = w->port->data ? *input++ : 0; bits; bits &= bits - 1)
        value ^= static_cast<uint32_t>(*pattern++ >> n & 1) * (bits & -bits);
      w->glue.put(value);
    }
    rack_.glue_.eval();
    size_t at = 0;
    const auto look = [&](const Net &net) {
      outputs.resize(std::max(outputs.size(), at + static_cast<size_t>(net.width)));
      for (int b = 0; b < net.width; ++b, ++at) outputs[at] |= (net.get() >> b & 1) << n;
    };
    for (const auto &[net, to] : rack_.glue_nets_) look(net);
    look(rack_.vme_data_);
  }
  for (const uint64_t pattern : outputs) {
    const bool zeros = pattern == 0, ones = pattern == ~uint64_t{0};
    found.push_back({zeros || ones ? GlueBit::kConstant : GlueBit::kMixed, ones});
    for (size_t d = 0; d < data; ++d) {
      if (pattern == patterns[d] || pattern == ~patterns[d])
        found.back() = {static_cast<int>(d), pattern != patterns[d]};
    }
  }
  return found;
}

// Of each net that the glue drives for boards, then of the data that the bus master reads.
std::vector<Word> Rack::Cycles::glue_outputs(Words &words) {
  std::vector<uint32_t> inputs;  // what is no data; and which bits are
  std::vector<Word> data;        // of each bit of data
  for (const Wire *w : rack_.glue_wires_) {
    const Word word = words.bits(kFirstNet + 2 * rack_.nets_.at(w->net, 0), w->lsb, w->width);
    if (!w->port->data) {
      inputs.push_back(words.decided(word));
      continue;
    }
    uint32_t bits = 0;
    for (int b = 0; b < w->width; ++b) {
      const Word bit = word.moved(-b, 1);
      if (bit.count == 0) continue;
      bits |= 1u << b;
      data.push_back(bit);
    }
    inputs.push_back(word.constant & ~bits);
    inputs.push_back(bits);
  }
  auto from = glue(inputs, data.size()).begin();
  std::vector<Word> outputs(rack_.glue_nets_.size() + 1);
  for (size_t n = 0; n < outputs.size(); ++n) {
    const Net &net = n < rack_.glue_nets_.size() ? rack_.glue_nets_[n].first : rack_.vme_data_;
    for (int b = 0; b < net.width; ++b, ++from) {
      if (from->data == GlueBit::kMixed) throw NoTrace{};
      if (from->data >= 0) outputs[n].add(data[static_cast<size_t>(from->data)].moved(b, 1u << b));
      outputs[n].constant ^= uint32_t{from->inverted} << b;
    }
  }
  return outputs;
}

}  // namespace mmcs
