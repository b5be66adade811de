// SPDX-License-Identifier: Apache-2.0
// Replays what the inputs of rtl/mmcs.sv were set to, on a model made by Verilator.
// Arguments: the record (lines "clock field value"), the last clock. Prints the number of clocks
// after which the outputs differ from the recorded ones.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "Vmmcs.h"
#include "verilated.h"
static VerilatedContext context;
static Vmmcs model(&context);
template <class T>
static void put(T &port, int lsb, uint32_t mask, uint32_t value) {
  port = static_cast<T>((port & ~(mask << lsb)) | value << lsb);
}
template <std::size_t N>
static void put(VlWide<N> &port, int lsb, uint32_t, uint32_t value) {
  port[lsb / 32] = value;
}

struct Change {
  long clock;
  uint32_t field, value;
};

static void apply(const Change &change) {
  switch (change.field) {
#define FIELD(number, port, lsb, width) \
  case number:                          \
    return put(model.port, lsb, 0xFFFFFFFF >> (32 - width), change.value);
#include "fields.inc"
  }
}

int main(int, char **arguments) {
  std::vector<Change> record;
  FILE *file = fopen(arguments[1], "r");
  for (Change c; fscanf(file, "%ld %u %u", &c.clock, &c.field, &c.value) == 3;) record.push_back(c);
  const long last = atol(arguments[2]);
  uint32_t expected = 0;
  long other = 0;
  auto change = record.begin();
  for (long t = change->clock; t < last; ++t) {
    put(model.clk_i, 0, 1, 1);
    model.eval();
    for (; change != record.end() && change->clock == t; ++change) {
      if (change->field == ANSWER) expected = change->value;
      apply(*change);
    }
    put(model.clk_i, 0, 1, 0);
    model.eval();
    const uint32_t found = model.vme_dtack_no << 9 | model.vme_d_oe_o << 8 | (model.vme_d_o & 0xFF);
    other += t >= 0 && found != expected;
  }
  printf("%ld\n", other);
}
