#include "fix_stage.h"

#include <cstring>

#include "comm.h"
#include "error.h"
#include "stop_with_error.h"
#include "modify.h"
#include "restart_state.h"
#include "update.h"

using namespace LAMMPS_NS;

FixStage::FixStage(LAMMPS *lmp, int narg, char **arg)
    : Fix(lmp, narg, arg),
      start_step_(update->ntimestep),
      segment_step_(update->ntimestep),
      segment_time_(0.0),
      segment_dt_(0.0) {
  if (narg != 5) error->fix_error(FLERR, this, "expects NAME FILE");
  name_ = arg[3];
  state_file_ = arg[4];
  vector_flag = 1;
  size_vector = 2;
  global_freq = 1;
  extvector = 0;
  restart_global = 1;
}

FixStage *FixStage::find(LAMMPS *lmp) {
  FixStage *stage = dynamic_cast<FixStage *>(lmp->modify->find_fix_style("ballast/stage", 0));
  if (!stage) ballast::stop_with_error(lmp, "no stage clock: the deck needs `fix ID all ballast/stage` first");
  return stage;
}

void FixStage::init() { reset_dt(); }

void FixStage::reset_dt() {
  if (segment_dt_ == update->dt) return;
  segment_time_ = time();
  segment_step_ = update->ntimestep;
  segment_dt_ = update->dt;
}

bigint FixStage::step() const { return update->ntimestep - start_step_; }

double FixStage::time() const { return segment_time_ + (update->ntimestep - segment_step_) * segment_dt_; }

double FixStage::compute_vector(int n) { return n == 0 ? static_cast<double>(step()) : time(); }

int FixStage::modify_param(int, char **arg) {
  if (strcmp(arg[0], "start") != 0) return 0;
  start_step_ = segment_step_ = update->ntimestep;
  segment_time_ = 0.0;
  return 1;
}

void FixStage::write_restart(FILE *file) {
  ballast::write_state(
      file, comm->me,
      {static_cast<double>(start_step_), static_cast<double>(segment_step_), segment_time_, segment_dt_});
}

void FixStage::restart(char *buffer) {
  const double *state = reinterpret_cast<double *>(buffer);
  start_step_ = static_cast<bigint>(state[0]);
  segment_step_ = static_cast<bigint>(state[1]);
  segment_time_ = state[2];
  segment_dt_ = state[3];
}
