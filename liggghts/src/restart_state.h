// Global state of a fix in LIGGGHTS' restart file: a list of doubles.
#ifndef BALLAST_RESTART_STATE_H
#define BALLAST_RESTART_STATE_H

#include <cstdio>
#include <vector>

namespace ballast {

/// Called by all ranks; rank 0 writes.
inline void write_state(FILE *file, int rank, const std::vector<double> &state) {
  if (rank != 0) return;
  const int bytes = static_cast<int>(state.size() * sizeof(double));
  fwrite(&bytes, sizeof(int), 1, file);
  fwrite(state.data(), sizeof(double), state.size(), file);
}

}  // namespace ballast

#endif
