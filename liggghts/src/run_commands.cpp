// Commands that report and steer a run: state rows, checkpoints, stop requests, ends.
#include <fcntl.h>
#include <mpi.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "comm.h"
#include "commands.h"
#include "error.h"
#include "stop_with_error.h"
#include "fix_bed_state.h"
#include "fix_stage.h"
#include "force.h"
#include "input.h"
#include "lammps.h"
#include "modify.h"
#include "stop_request.h"

using namespace LAMMPS_NS;

namespace ballast {

namespace {

/// Bytes: less than this is free only where a file did not fit.
const int SPACE_LEFT_BY_A_WHOLE_FILE = 65536;

/// All ranks together.
void leave(LAMMPS *lmp, int status) {
  fflush(NULL);
  MPI_Barrier(lmp->world);
  MPI_Finalize();
  std::exit(status);
}

}  // namespace

void write_state_row(LAMMPS *lmp, int narg, char **arg) {
  if (narg != 2) stop_with_error(lmp, "write_state: expects FILE STAGE");
  FixBedState *fix = dynamic_cast<FixBedState *>(lmp->modify->find_fix_style("ballast/state", 0));
  if (!fix) stop_with_error(lmp, "write_state: the deck needs `fix ID all ballast/state` first");
  const FixStage *stage = FixStage::find(lmp);
  const BedState &s = fix->state();
  if (lmp->comm->me != 0) return;
  FILE *file = fopen(arg[0], "a");
  bool written = file != NULL;
  if (file) {
    fseek(file, 0, SEEK_END);
    if (ftell(file) == 0)
      fprintf(
          file,
          "stage,step,time_s,kinetic_energy_J,unbalanced_ratio,overlap_max_ratio,overlap_mean_m,contacts,clumps,at_limit_share,"
          "sliding_share\n");
    fprintf(file, "%s,%lld,%.17g,%.17g,%.17g,%.17g,%.17g,%.0f,%.0f,%.17g,%.17g\n", arg[1],
            static_cast<long long>(stage->step()), stage->time(), s.kinetic_energy, s.unbalanced_ratio,
            s.overlap_max_ratio, s.overlap_mean, s.contacts, s.clumps, s.at_limit_share, s.sliding_share);
    written = fflush(file) == 0 && !ferror(file);
    written = fclose(file) == 0 && written;
  }
  if (!written)
    stop_with_error(lmp,
                    std::string(arg[0]) + ": cannot be written (" + strerror(errno) + "); free disk space and resume");
}

namespace {

/// True where so much can still be written beside `path`: neither disk nor quota is full.
bool has_room(const std::string &path) {
  const std::string name = path + ".room.partial";
  const int descriptor = open(name.c_str(), O_WRONLY | O_CREAT, 0600);
  if (descriptor < 0) return false;
  const int failure = posix_fallocate(descriptor, 0, SPACE_LEFT_BY_A_WHOLE_FILE);
  close(descriptor);
  unlink(name.c_str());
  if (failure) errno = failure;
  return failure == 0;
}

}  // namespace

void write_checkpoint(LAMMPS *lmp, int narg, char **arg) {
  if (narg != 1) stop_with_error(lmp, "write_checkpoint: expects FILE");
  const std::string path = arg[0], partial = path + ".partial";
  lmp->input->one(("write_restart " + partial).c_str());
  if (lmp->comm->me == 0) {
    // LIGGGHTS does not notice a full disk: what does not fit is silently missing
    const int descriptor = open(partial.c_str(), O_RDONLY);
    const bool on_disk = descriptor >= 0 && fsync(descriptor) == 0 && has_room(path);
    if (descriptor >= 0) close(descriptor);
    if (!on_disk || rename(partial.c_str(), path.c_str()) != 0) {
      const std::string reason = strerror(errno);
      unlink(partial.c_str());
      stop_with_error(
          lmp, path + ": cannot be written (" + reason + "); free disk space or correct permissions, then resume");
    }
  }
  MPI_Barrier(lmp->world);
}

void stop_requested(LAMMPS *lmp, int narg, char **arg) {
  if (narg != 1) stop_with_error(lmp, "stop_requested: expects the NAME of a variable");
  const int mine = stop_signal_came();
  int any;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, lmp->world);
  const std::string line = std::string("variable ") + arg[0] + (any ? " equal 1" : " equal 0");
  lmp->input->one(line.c_str());
}

void end_run(LAMMPS *lmp, int narg, char **arg) {
  if (narg != 1) stop_with_error(lmp, "end_run: expects an exit status");
  leave(lmp, lmp->force->inumeric(FLERR, arg[0]));
}

void fail(LAMMPS *lmp, int narg, char **arg) {
  if (narg != 1) stop_with_error(lmp, "fail: expects one quoted text");
  // quoted text reaches a command with its variables still unresolved
  int room = static_cast<int>(strlen(arg[0])) + 1, room_copy = room;
  char *text = static_cast<char *>(malloc(room)), *copy = static_cast<char *>(malloc(room));
  strcpy(text, arg[0]);
  lmp->input->substitute(text, copy, room, room_copy, 0);
  const std::string resolved = text;
  free(text);
  free(copy);
  stop_with_error(lmp, resolved);
}

}  // namespace ballast
