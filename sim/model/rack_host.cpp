// SPDX-License-Identifier: Apache-2.0
// The board of a SoC's host in a rack: it has more clocks than the machine, and a rest of its own.

#include "rack.h"

namespace mmcs {

// The host's clocks between two of the machine, and what follows from them, before edge clock_ + 1.
void Rack::host_clocks() {
  catch_up_host();
  before_clock();
  host_->refresh();
  tell(*host_);
  settle();
}

// It needs the next edge, or none until something happens to it.
void Rack::plan_host(bool due) {
  host_due_ = due ? clock_ + 1 : kNever;
}

void Rack::catch_up_host() {
  if (host_clock_ < clock_) host_pass(clock_ - host_clock_);
  host_clock_ = clock_;
}

// Something came to it from above.
void Rack::wake_host() {
  plan_host(true);
  host_->refresh();
  tell(*host_);
  settle();
}

}  // namespace mmcs
