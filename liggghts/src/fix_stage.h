#ifndef BALLAST_FIX_STAGE_H
#define BALLAST_FIX_STAGE_H

#include <string>

#include "fix.h"

namespace LAMMPS_NS {

/// `fix ID all ballast/stage NAME FILE`: step and time since the start of a stage (packing, preload, cyclic); FILE
/// takes rows of the bed's state. Step and time are kept in restart files, so that LIGGGHTS' own step runs on: contacts
/// remember the step of their last touch.
///   fix_modify ID start      the stage starts at the present step
/// Outputs: [1] step of the stage, [2] time of the stage (s).
class FixStage : public Fix {
 public:
  FixStage(class LAMMPS *, int, char **);
  int setmask() override { return 0; }
  void init() override;
  void reset_dt() override;
  double compute_vector(int) override;
  int modify_param(int, char **) override;
  void write_restart(FILE *) override;
  void restart(char *) override;

  bigint step() const;
  /// s; exactly step x time step as long as the time step does not change.
  double time() const;

  const std::string &name() const { return name_; }
  const std::string &state_file() const { return state_file_; }

  /// The stage fix of the deck; ends the run if there is none.
  static FixStage *find(class LAMMPS *);

 private:
  std::string name_, state_file_;
  bigint start_step_;  // of the stage
  bigint segment_step_;  // where the present time step began to hold
  double segment_time_;  // time of the stage at that step, s
  double segment_dt_;  // s; 0 before the first run
};

}  // namespace LAMMPS_NS

#endif
