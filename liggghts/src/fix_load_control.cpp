#include "fix_load_control.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <string>

#include "comm.h"
#include "error.h"
#include "stop_with_error.h"
#include "fix_stage.h"
#include "fix_wall.h"
#include "force.h"
#include "modify.h"
#include "restart_state.h"
#include "update.h"

using namespace LAMMPS_NS;
using namespace FixConst;

FixLoadControl::FixLoadControl(LAMMPS *lmp, int narg, char **arg)
    : Fix(lmp, narg, arg),
      stage_(NULL),
      law_(FIXED),
      mass_(0.0),
      drag_(0.0),
      gain_(0.0),
      gain_step_(0.0),
      stiffness_(0.0),
      velocity_limit_(0.0),
      contact_floor_(0.0),
      count_interval_(0),
      target_style_(NONE),
      ramp_start_(0.0),
      velocity_(0.0),
      travel_(0.0),
      contact_force_(0.0),
      contacts_(0),
      stress_sum_(0.0),
      squared_error_sum_(0.0),
      row_steps_(0),
      averaging_time_(0.0),
      window_next_(0),
      window_full_(false) {
  if (narg != 10 || strcmp(arg[4], "direction") != 0 || strcmp(arg[8], "area") != 0)
    error->fix_error(FLERR, this, "expects WALL_FIX direction X Y Z area A");
  wall_ = dynamic_cast<FixWall *>(modify->find_fix_id(arg[3]));
  if (!wall_) error->fix_error(FLERR, this, "first argument must be the id of a fix ballast/wall");
  for (int d = 0; d < 3; d++) direction_[d] = number(narg, arg, 5 + d);
  area_ = number(narg, arg, 9);
  if (area_ <= 0.0) error->fix_error(FLERR, this, "area must be positive");
  std::fill(target_values_, target_values_ + 3, 0.0);
  vector_flag = 1;
  size_vector = 9;
  global_freq = 1;
  extvector = 0;
  restart_global = 1;
}

void FixLoadControl::pre_delete(bool unfix) {
  if (!unfix) return;
  velocity_ = 0.0;
  set_wall_velocity();
}

int FixLoadControl::setmask() { return INITIAL_INTEGRATE | FINAL_INTEGRATE; }

void FixLoadControl::init() {
  if (law_ == FORCE && !(mass_ > 0.0)) error->fix_error(FLERR, this, "law force needs a positive mass");
  if (law_ == PFC && !(stiffness_ > 0.0 && velocity_limit_ > 0.0 && count_interval_ >= 1 && contact_floor_ >= 1.0))
    error->fix_error(
        FLERR, this,
        "law pfc needs a positive stiffness and velocity_limit, count_interval and contact_floor of at least 1");
  stage_ = FixStage::find(lmp);
  const std::size_t steps = static_cast<std::size_t>(averaging_time_ / update->dt + 0.5);
  if (steps != window_.size()) {
    window_.assign(steps, 0.0);
    window_next_ = 0;
    window_full_ = false;
  }
  // before the forces of the run's set-up, whose dashpots need the wall's velocity: a resumed run must compute the same
  // ones
  set_wall_velocity();
}

void FixLoadControl::set_wall_velocity() {
  double velocity[3];
  for (int d = 0; d < 3; d++) velocity[d] = velocity_ * direction_[d];
  wall_->set_velocity(velocity);
}

void FixLoadControl::initial_integrate(int) {
  if (!moves()) return;
  double step[3];
  for (int d = 0; d < 3; d++) step[d] = velocity_ * update->dt * direction_[d];
  travel_ += velocity_ * update->dt;
  wall_->move(step);
  set_wall_velocity();
}

void FixLoadControl::final_integrate() {
  double force[3];
  wall_->total_force(force);
  contact_force_ = -(force[0] * direction_[0] + force[1] * direction_[1] + force[2] * direction_[2]);
  const double wanted = target(), error_force = wanted * area_ - contact_force_;
  if (moves() && law_ == FORCE) {
    velocity_ += update->dt * (error_force - drag_ * velocity_) / mass_;
  } else if (moves() && law_ == PFC) {
    if (stage_->step() % count_interval_ == 0 || contacts_ == 0) contacts_ = wall_->total_contacts();
    const double wall_stiffness = stiffness_ * std::max(static_cast<double>(contacts_), contact_floor_);
    velocity_ = gain_ * error_force / (wall_stiffness * (gain_step_ > 0.0 ? gain_step_ : update->dt));
    velocity_ = std::min(velocity_limit_, std::max(-velocity_limit_, velocity_));
  }
  const double stress_error = stress() - wanted;
  stress_sum_ += stress();
  squared_error_sum_ += stress_error * stress_error;
  row_steps_++;
  if (window_.empty()) return;
  window_[window_next_] = stress();
  if (++window_next_ == window_.size()) {
    window_next_ = 0;
    window_full_ = true;
  }
}

double FixLoadControl::target() const {
  if (target_style_ == NONE || target_style_ == CONSTANT) return target_values_[0];
  const double time = stage_ ? stage_->time() : 0.0;
  if (target_style_ == HARMONIC)
    return target_values_[0] - target_values_[1] * cos(2.0 * M_PI * target_values_[2] * time);
  const double share = std::min(1.0, (time - ramp_start_) / target_values_[2]);
  return target_values_[0] + share * (target_values_[1] - target_values_[0]);
}

double FixLoadControl::mean_squared_error() const {
  if (row_steps_) return squared_error_sum_ / row_steps_;
  const double stress_error = stress() - target();
  return stress_error * stress_error;
}

void FixLoadControl::start_row() {
  stress_sum_ = squared_error_sum_ = 0.0;
  row_steps_ = 0;
}

double FixLoadControl::window_mean() const {
  return window_full_ ? std::accumulate(window_.begin(), window_.end(), 0.0) / window_.size() : 0.0;
}

double FixLoadControl::deviation() const {
  if (!moves()) return 0.0;
  return window_full_ ? fabs(window_mean() / target() - 1.0) : 1.0;
}

double FixLoadControl::compute_vector(int n) {
  switch (n) {
    case 0:
      return target();
    case 1:
      return stress();
    case 2:
      return mean_stress();
    case 3:
      return mean_squared_error();
    case 4:
      return travel_;
    case 5:
      return velocity_;
    case 6:
      return window_mean();
    case 7:
      return contacts_;
    default:
      return deviation();
  }
}

double FixLoadControl::number(int narg, char **arg, int index) const {
  if (index >= narg) ballast::stop_with_error(lmp, std::string("fix ") + id + ": a number is missing at the end");
  return force->numeric(FLERR, arg[index]);
}

int FixLoadControl::modify_param(int narg, char **arg) {
  const std::string key = arg[0];
  if (narg < 2) return 0;
  int used = 2;
  if (key == "law")
    parse_law(arg[1]);
  else if (key == "target")
    parse_target(narg, arg, used);
  else if (key == "mass")
    mass_ = number(narg, arg, 1);
  else if (key == "drag")
    drag_ = number(narg, arg, 1);
  else if (key == "gain")
    gain_ = number(narg, arg, 1);
  else if (key == "gain_step")
    gain_step_ = number(narg, arg, 1);
  else if (key == "stiffness")
    stiffness_ = number(narg, arg, 1);
  else if (key == "velocity_limit")
    velocity_limit_ = number(narg, arg, 1);
  else if (key == "count_interval")
    count_interval_ = static_cast<int>(number(narg, arg, 1));
  else if (key == "contact_floor")
    contact_floor_ = number(narg, arg, 1);
  else if (key == "averaging_time")
    averaging_time_ = number(narg, arg, 1);
  else
    return 0;
  return used;
}

void FixLoadControl::parse_law(const char *name) {
  if (strcmp(name, "fixed") == 0)
    law_ = FIXED;
  else if (strcmp(name, "force") == 0)
    law_ = FORCE;
  else if (strcmp(name, "pfc") == 0)
    law_ = PFC;
  else
    error->fix_error(FLERR, this, "law must be fixed, force or pfc");
  if (law_ == FIXED) velocity_ = 0.0;
}

void FixLoadControl::parse_target(int narg, char **arg, int &used) {
  int values = 0;
  if (strcmp(arg[1], "constant") == 0) {
    target_style_ = CONSTANT;
    values = 1;
  } else if (strcmp(arg[1], "ramp") == 0) {
    target_style_ = RAMP;
    ramp_start_ = FixStage::find(lmp)->time();
    values = 3;
  } else if (strcmp(arg[1], "harmonic") == 0) {
    target_style_ = HARMONIC;
    values = 3;
  } else {
    error->fix_error(FLERR, this, "target must be constant, ramp or harmonic");
  }
  for (int n = 0; n < values; n++) target_values_[n] = number(narg, arg, 2 + n);
  if (target_style_ == RAMP && target_values_[2] <= 0.0)
    error->fix_error(FLERR, this, "target ramp: its time must be positive");
  used = 2 + values;
}

void FixLoadControl::write_restart(FILE *file) {
  ballast::write_state(file, comm->me,
                       {velocity_, travel_, contact_force_, static_cast<double>(contacts_), stress_sum_,
                        squared_error_sum_, static_cast<double>(row_steps_)});
}

void FixLoadControl::restart(char *buffer) {
  const double *state = reinterpret_cast<double *>(buffer);
  velocity_ = state[0];
  travel_ = state[1];
  contact_force_ = state[2];
  contacts_ = static_cast<int>(state[3]);
  stress_sum_ = state[4];
  squared_error_sum_ = state[5];
  row_steps_ = static_cast<bigint>(state[6]);
}
