#include "fix_history.h"

#include <cerrno>
#include <cstring>

#include "comm.h"
#include "error.h"
#include "stop_with_error.h"
#include "fix_load_control.h"
#include "fix_stage.h"
#include "force.h"
#include "modify.h"

using namespace LAMMPS_NS;
using namespace FixConst;

FixHistory::FixHistory(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg), file_(NULL), stage_(NULL) {
  if (narg < 7) error->fix_error(FLERR, this, "expects EVERY FILE new|append SLEEPER_LOAD PLATE_LOAD_1 ...");
  nevery = 1;
  row_interval_ = force->inumeric(FLERR, arg[3]);
  if (row_interval_ < 1) error->fix_error(FLERR, this, "EVERY must be at least 1");
  path_ = arg[4];
  const bool append = strcmp(arg[5], "append") == 0;
  sleeper_ = find_load(arg[6]);
  for (int n = 7; n < narg; n++) plates_.push_back(find_load(arg[n]));
  if (comm->me == 0) {
    file_ = fopen(path_.c_str(), append ? "a" : "w");
    if (!file_)
      ballast::stop_with_error(lmp,
                               path_ + ": cannot be written; make the folder and check free space and permissions");
    fseek(file_, 0, SEEK_END);
    if (ftell(file_) == 0) write_header();
  }
}

FixHistory::~FixHistory() {
  if (file_) fclose(file_);
}

FixLoadControl *FixHistory::find_load(const char *id) const {
  FixLoadControl *load = dynamic_cast<FixLoadControl *>(modify->find_fix_id(id));
  if (!load)
    ballast::stop_with_error(lmp,
                             std::string("fix ballast/history: ") + id + " is not a fix ballast/load; define it first");
  return load;
}

int FixHistory::setmask() { return END_OF_STEP; }

void FixHistory::init() { stage_ = FixStage::find(lmp); }

void FixHistory::setup(int) {
  if (stage_->step() == 0) write_row();
}

void FixHistory::end_of_step() {
  if (stage_->step() % row_interval_ == 0) write_row();
}

void FixHistory::write_header() {
  fprintf(
      file_,
      "step,time_s,sleeper_target_Pa,sleeper_stress_Pa,sleeper_stress_mean_Pa,sleeper_error_ms_Pa2,sleeper_displacement_m");
  for (std::size_t n = 1; n <= plates_.size(); n++)
    fprintf(file_, ",plate_%zu_stress_Pa,plate_%zu_stress_mean_Pa,plate_%zu_displacement_m", n, n, n);
  fprintf(file_, "\n");
  flush();
}

void FixHistory::flush() {
  // what did not fit into the buffer went out, or failed, before
  if (fflush(file_) != 0 || ferror(file_))
    ballast::stop_with_error(lmp, path_ + ": cannot be written (" + strerror(errno) + "); free disk space and resume");
}

void FixHistory::write_row() {
  if (file_) {
    fprintf(file_, "%lld,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g", static_cast<long long>(stage_->step()), stage_->time(),
            sleeper_->target(), sleeper_->stress(), sleeper_->mean_stress(), sleeper_->mean_squared_error(),
            sleeper_->travel());
    for (const FixLoadControl *plate : plates_)
      fprintf(file_, ",%.17g,%.17g,%.17g", plate->stress(), plate->mean_stress(), 0.0 - plate->travel());
    fprintf(file_, "\n");
    flush();
  }
  sleeper_->start_row();
  for (FixLoadControl *plate : plates_) plate->start_row();
}
