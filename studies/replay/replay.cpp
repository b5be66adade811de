// SPDX-License-Identifier: Apache-2.0
// Replays what the inputs of rtl/mmcs.sv were set to, on a model made by Verilator or CXXRTL.
// Arguments: the record (lines "clock field value"), the last clock. Prints the number of clocks
// after which the outputs differ from the recorded ones.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#ifdef CXXRTL
#include "mmcs_cxxrtl.cc"
#define PORT(in_cxxrtl, name) p_##in_cxxrtl
static cxxrtl_design::p_mmcs model;
static void eval() {
  model.step();
}
template <class T>
static void put(T &port, int lsb, uint32_t mask, uint32_t value) {
  uint32_t &word = port.data[lsb / 32];
  word = (word & ~(mask << lsb % 32)) | value << lsb % 32;
}
template <class T>
static uint32_t get(const T &port) {
  return port.template get<uint32_t>();
}
#else
#include "Vmmcs.h"
#include "verilated.h"
#define PORT(in_cxxrtl, name) name
static VerilatedContext context;
static Vmmcs model(&context);
static void eval() {
  model.eval();
}
template <class T>
static void put(T &port, int lsb, uint32_t mask, uint32_t value) {
  port = static_cast<T>((port & ~(mask << lsb)) | value << lsb);
}
template <std::size_t N>
static void put(VlWide<N> &port, int lsb, uint32_t, uint32_t value) {
  port[lsb / 32] = value;
}
template <class T>
static uint32_t get(const T &port) {
  return port;
}
#endif

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
    put(model.PORT(clk__i, clk_i), 0, 1, 1);
    eval();
    for (; change != record.end() && change->clock == t; ++change) {
      if (change->field == ANSWER) expected = change->value;
      apply(*change);
    }
    put(model.PORT(clk__i, clk_i), 0, 1, 0);
    eval();
    const uint32_t found = get(model.PORT(vme__dtack__no, vme_dtack_no)) << 9 |
                           get(model.PORT(vme__d__oe__o, vme_d_oe_o)) << 8 |
                           (get(model.PORT(vme__d__o, vme_d_o)) & 0xFF);
    other += t >= 0 && found != expected;
  }
  printf("%ld\n", other);
}
