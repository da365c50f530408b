#include "fix_bed_state.h"

#include <algorithm>

#include "error.h"
#include "update.h"

using namespace LAMMPS_NS;

/// Stands for the infinite ratio of a bed without contacts: the deck's `if` cannot read `inf`.
static const double NOT_BALANCED = 1e300;

FixBedState::FixBedState(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg), step_(-1), state_() {
  if (narg != 3) error->fix_error(FLERR, this, "takes no arguments");
  vector_flag = 1;
  size_vector = 8;
  global_freq = 1;
  extvector = 0;
}

const ballast::BedState &FixBedState::state() {
  if (step_ != update->ntimestep) {
    state_ = ballast::evaluate_bed(lmp);
    step_ = update->ntimestep;
  }
  return state_;
}

double FixBedState::compute_vector(int n) {
  const ballast::BedState &now = state();
  const double values[] = {now.kinetic_energy,    std::min(now.unbalanced_ratio, NOT_BALANCED),
                           now.overlap_max_ratio, now.overlap_mean,
                           now.contacts,          now.clumps,
                           now.at_limit_share,    now.sliding_share};
  return values[n];
}
