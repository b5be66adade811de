// SPDX-License-Identifier: Apache-2.0
// What the model asks of Verilator's run-time library: contexts, variables by name.

#include <cstdarg>
#include <cstdio>

#include "board.h"

#include "verilated.h"
#include "verilated_sym_props.h"

namespace mmcs {

thread_local std::string printed;  // by models of this thread, or where they stopped; plain.cpp's

Context create_context(uint64_t seed) {
  const Context context(new VerilatedContext);
  context->randReset(2);
  context->randSeed(static_cast<int>(seed % 0x7FFFFFFF) + 1);
  use(context);
  return context;
}

void use(const Context &context) {
  Verilated::threadContextp(context.get());
}

Net find_net(const VerilatedContext &context, const std::string &scope, const std::string &name) {
  const VerilatedScope *s = context.scopeFind(scope.c_str());
  const VerilatedVar *v = s ? s->varFind(name.c_str()) : nullptr;
  if (!v) return {};
  Net net;
  net.at = static_cast<char *>(v->datap());
  net.bytes = static_cast<int>(v->totalSize());
  net.width = static_cast<int>(v->entBits());
  net.entry = static_cast<int>(v->entSize());
  return net;
}

}  // namespace mmcs

// Verilator's run-time library prints and stops through these.
extern "C" int mmcs_model_print(const char *format, ...) {
  char text[400];
  va_list arguments;
  va_start(arguments, format);
  const int length = vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  mmcs::printed += text;
  while (!mmcs::printed.empty() && mmcs::printed.back() == '\n') mmcs::printed.pop_back();
  return length;
}

void vl_stop(const char *file, int line, const char *) {
  if (mmcs::printed.empty()) mmcs::printed = std::string(file) + ":" + std::to_string(line);
  Verilated::threadContextp()->gotError(true);
}

#ifdef __EMSCRIPTEN__  // what it asks about processors: in a page, no answer
#include <pthread.h>
#include <sched.h>

#include <cerrno>

extern "C" {
int pthread_getaffinity_np(pthread_t, size_t, cpu_set_t *) {
  return ENOSYS;
}
int pthread_setaffinity_np(pthread_t, size_t, const cpu_set_t *) {
  return ENOSYS;
}
int sched_getcpu() {
  return -1;
}
}
#endif
