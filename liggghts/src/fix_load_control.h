#ifndef BALLAST_FIX_LOAD_CONTROL_H
#define BALLAST_FIX_LOAD_CONTROL_H

#include <vector>

#include "fix.h"

namespace LAMMPS_NS {

/// Presses a wall on the bed along one direction, or measures what the bed does to it.
///   fix ID all ballast/load WALL_FIX direction X Y Z area A
///   fix_modify ID law fixed                                measure only
///   fix_modify ID law force mass M drag C                  M dv/dt = target force - contact force - C v   (kg, N s/m)
///   fix_modify ID law pfc gain A gain_step DT stiffness KN count_interval N contact_floor F velocity_limit V
///                                                          v = A (target force - contact force) / (KN N_c DT), limited
///   fix_modify ID target constant S | ramp S1 S2 T | harmonic MEAN AMPLITUDE FREQUENCY
///   fix_modify ID averaging_time T                         window of output 7, s
/// DT is the time step that the gain is meant for (0 or not given: the run's own). Stresses in Pa, positive = bed
/// pushes back; the wall is held until it has a target. A ramp begins at the present step, a harmonic target is MEAN -
/// AMPLITUDE cos(2 pi FREQUENCY t) with t the time of the stage. Travel, velocity, contact force, contact count and the
/// sums since the last output row are kept in restart files; law and target come from the deck. Outputs: [1] target
/// (Pa), [2] stress (Pa), [3] mean stress since the last row (Pa), [4] mean squared error since then (Pa2), [5] travel
/// along the direction (m), [6] velocity (m/s), [7] mean stress over the averaging window (Pa; 0 until it is full), [8]
/// contacts of the wall when last counted, [9] `deviation`.
class FixLoadControl : public Fix {
 public:
  FixLoadControl(class LAMMPS *, int, char **);
  void pre_delete(bool) override;
  int setmask() override;
  void init() override;
  void initial_integrate(int) override;
  void final_integrate() override;
  double compute_vector(int) override;
  int modify_param(int, char **) override;
  void write_restart(FILE *) override;
  void restart(char *) override;

  double target() const;  // Pa, at the present step
  double stress() const { return contact_force_ / area_; }
  double mean_stress() const { return row_steps_ ? stress_sum_ / row_steps_ : stress(); }
  double mean_squared_error() const;
  double travel() const { return travel_; }
  /// Relative deviation of the window's mean from the target: 0 where the wall does not move, 1 until the window is
  /// full.
  double deviation() const;
  /// Begin a new output row.
  void start_row();

 private:
  enum Law { FIXED, FORCE, PFC };
  enum Target { NONE, CONSTANT, RAMP, HARMONIC };

  void parse_law(const char *name);
  void parse_target(int narg, char **arg, int &used);
  double number(int narg, char **arg, int index) const;
  void set_wall_velocity();
  double window_mean() const;
  bool moves() const { return law_ != FIXED && target_style_ != NONE; }

  class FixWall *wall_;
  class FixStage *stage_;
  double direction_[3], area_;

  Law law_;
  double mass_, drag_;  // force law
  double gain_, gain_step_, stiffness_, velocity_limit_, contact_floor_;  // pfc law
  int count_interval_;
  Target target_style_;
  double target_values_[3];
  double ramp_start_;  // stage time, s

  double velocity_, travel_, contact_force_;
  int contacts_;
  double stress_sum_, squared_error_sum_;
  bigint row_steps_;

  double averaging_time_;
  std::vector<double> window_;  // ring of stresses, Pa
  std::size_t window_next_;
  bool window_full_;
};

}  // namespace LAMMPS_NS

#endif
