#include "stop_request.h"

#include <csignal>
#include <cstring>

namespace ballast {

namespace {

volatile std::sig_atomic_t stop_signal = 0;

void remember(int) { stop_signal = 1; }

}  // namespace

void watch_stop_signals() {
  struct sigaction action;
  memset(&action, 0, sizeof action);
  action.sa_handler = remember;
  action.sa_flags = SA_RESTART;
  sigaction(SIGTERM, &action, NULL);
  sigaction(SIGINT, &action, NULL);
}

bool stop_signal_came() { return stop_signal != 0; }

}  // namespace ballast
