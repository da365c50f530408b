// SIGTERM and SIGINT ask for a stop at the end of the block; LIGGGHTS' own handler would stop in the middle of one.
#ifndef BALLAST_STOP_REQUEST_H
#define BALLAST_STOP_REQUEST_H

namespace ballast {

void watch_stop_signals();
bool stop_signal_came();

}  // namespace ballast

#endif
