// Commands that run a stage: in blocks, to rest, cycle by cycle; state rows, checkpoints and stop requests.
#include <fcntl.h>
#include <mpi.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "bed_state.h"
#include "comm.h"
#include "commands.h"
#include "deck.h"
#include "error.h"
#include "stop_with_error.h"
#include "fix_load_control.h"
#include "fix_stage.h"
#include "force.h"
#include "input.h"
#include "lammps.h"
#include "modify.h"
#include "stop_request.h"

using namespace LAMMPS_NS;

namespace ballast {

namespace {

/// Exit status of a run that was stopped on request.
const int STOPPED = 75;

/// Bytes: less than this is free only where a file did not fit.
const int SPACE_LEFT_BY_A_WHOLE_FILE = 65536;

bigint whole_number(LAMMPS *lmp, const std::string &word) { return lmp->force->inumeric(FLERR, word.c_str()); }

/// Append the bed's state as a row to the file of the stage.
void write_state(LAMMPS *lmp, const BedState &s) {
  const FixStage *stage = FixStage::find(lmp);
  if (lmp->comm->me != 0) return;
  FILE *file = fopen(stage->state_file().c_str(), "a");
  bool written = file != NULL;
  if (file) {
    fseek(file, 0, SEEK_END);
    if (ftell(file) == 0)
      fprintf(
          file,
          "stage,step,time_s,kinetic_energy_J,unbalanced_ratio,overlap_max_ratio,overlap_mean_m,contacts,clumps,at_limit_share,"
          "sliding_share\n");
    fprintf(file, "%s,%lld,%.17g,%.17g,%.17g,%.17g,%.17g,%.0f,%.0f,%.17g,%.17g\n", stage->name().c_str(),
            static_cast<long long>(stage->step()), stage->time(), s.kinetic_energy, s.unbalanced_ratio,
            s.overlap_max_ratio, s.overlap_mean, s.contacts, s.clumps, s.at_limit_share, s.sliding_share);
    written = fflush(file) == 0 && !ferror(file);
    written = fclose(file) == 0 && written;
  }
  if (!written)
    stop_with_error(lmp,
                    stage->state_file() + ": cannot be written (" + strerror(errno) + "); free disk space and resume");
}

/// Run one block and write its row.
BedState advance_block(LAMMPS *lmp, bigint steps) {
  lmp->input->one(("run " + std::to_string(steps) + " post no").c_str());
  const BedState state = evaluate_bed(lmp);
  write_state(lmp, state);
  return state;
}

/// True on all ranks if a signal came to any of them.
bool stop_requested(LAMMPS *lmp) {
  const int mine = stop_signal_came();
  int any;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, lmp->world);
  return any != 0;
}

/// Leave at a stop request. All ranks together.
void end_stopped(LAMMPS *lmp) {
  const FixStage *stage = FixStage::find(lmp);
  if (lmp->comm->me == 0)
    printf("%s: stopped on request after step %lld\n", stage->name().c_str(), static_cast<long long>(stage->step()));
  fflush(NULL);
  MPI_Barrier(lmp->world);
  MPI_Finalize();
  std::exit(STOPPED);
}

/// Keywords with a number each, from word `first` on; those named must be there.
std::map<std::string, double> keywords(LAMMPS *lmp, const std::vector<std::string> &words, std::size_t first,
                                       const char *expected, const std::vector<std::string> &needed) {
  std::map<std::string, double> found;
  for (std::size_t n = first; n < words.size(); n += 2) {
    if (n + 1 == words.size()) stop_with_error(lmp, expected);
    found[words[n]] = lmp->force->numeric(FLERR, words[n + 1].c_str());
  }
  for (const std::string &key : needed)
    if (!(found[key] > 0.0)) stop_with_error(lmp, std::string(expected) + "; " + key + " is missing or not positive");
  return found;
}

}  // namespace

void advance(LAMMPS *lmp, int narg, char **arg) {
  const char *const expected = "advance: expects STEPS [block N]";
  const std::vector<std::string> words = kept(narg, arg);
  if (words.size() != 1 && (words.size() != 3 || words[1] != "block")) stop_with_error(lmp, expected);
  bigint left = whole_number(lmp, words[0]);
  const bigint block = words.size() == 3 ? whole_number(lmp, words[2]) : std::max<bigint>(1, left);
  if (block < 1) stop_with_error(lmp, expected);
  FixStage::find(lmp);  // ends a deck without a clock before anything runs
  for (; left > 0; left -= block) {
    advance_block(lmp, std::min(left, block));
    if (stop_requested(lmp)) end_stopped(lmp);
  }
}

void advance_to_rest(LAMMPS *lmp, int narg, char **arg) {
  const char *const expected =
      "advance_to_rest: expects unbalanced_ratio R kinetic_energy E time_limit T block N [stress_tolerance S]";
  std::map<std::string, double> limits =
      keywords(lmp, kept(narg, arg), 0, expected, {"unbalanced_ratio", "kinetic_energy", "time_limit", "block"});
  const bool loaded = limits.count("stress_tolerance") > 0;
  if (limits.size() != (loaded ? 5u : 4u)) stop_with_error(lmp, expected);
  const FixStage *stage = FixStage::find(lmp);
  const double end = stage->time() + limits["time_limit"];
  for (;;) {
    const BedState state = advance_block(lmp, static_cast<bigint>(limits["block"]));
    if (stop_requested(lmp)) end_stopped(lmp);
    double off = 0.0;  // of the load that is furthest from its target
    for (int n = 0; loaded && n < lmp->modify->nfix; n++)
      if (const FixLoadControl *load = dynamic_cast<FixLoadControl *>(lmp->modify->fix[n]))
        off = std::max(off, load->deviation());
    if (off <= limits["stress_tolerance"] && state.unbalanced_ratio <= limits["unbalanced_ratio"] &&
        state.kinetic_energy <= limits["kinetic_energy"])
      return;
    if (stage->time() < end) continue;
    std::ostringstream text;
    text << stage->name() << ": not at rest after " << limits["time_limit"] << " s: ";
    if (loaded)
      text << "a mean stress is off by " << off << " of its target (stress_tolerance " << limits["stress_tolerance"]
           << "), ";
    text << "unbalanced ratio " << state.unbalanced_ratio << " (unbalanced_ratio " << limits["unbalanced_ratio"]
         << "), kinetic energy " << state.kinetic_energy << " J per clump (kinetic_energy " << limits["kinetic_energy"]
         << "); raise time_limit, or what is named, in the scenario's sections packing, rest, preload";
    stop_with_error(lmp, text.str());
  }
}

namespace {

/// What advance_cycles does at the end of cycles.
struct Due {
  bigint every;                     // cycles; 0 = only those named
  std::vector<bigint> cycles;
  std::vector<std::string> commands;
  bool checkpoint;                  // also where the run is stopped

  bool after(bigint cycle) const {
    return (every > 0 && cycle % every == 0) || std::find(cycles.begin(), cycles.end(), cycle) != cycles.end();
  }
};

const char CYCLES_EXPECTED[] =
    "advance_cycles: expects CYCLES steps N block M, then every K \"COMMAND\" ..., at CYCLE ... do \"COMMAND\" ..., "
    "checkpoint K \"COMMAND\"";

std::vector<Due> parse_due(LAMMPS *lmp, const std::vector<std::string> &words) {
  std::vector<Due> rules;
  for (std::size_t n = 5; n < words.size(); n++) {
    const std::string &word = words[n];
    if (word == "every" || word == "checkpoint") {
      if (++n == words.size()) stop_with_error(lmp, CYCLES_EXPECTED);
      rules.push_back({whole_number(lmp, words[n]), {}, {}, word == "checkpoint"});
    } else if (word == "at") {
      Due rule = {0, {}, {}, false};
      for (n++; n < words.size() && words[n] != "do"; n++) rule.cycles.push_back(whole_number(lmp, words[n]));
      rules.push_back(rule);
    } else if (!rules.empty()) {
      rules.back().commands.push_back(word);
    } else {
      stop_with_error(lmp, CYCLES_EXPECTED);
    }
  }
  return rules;
}

void execute_all(LAMMPS *lmp, const Due &rule, const std::string &cycle) {
  for (const std::string &command : rule.commands) execute(lmp, with_value(command, "cycle", cycle));
}

/// A cycle in names of files: 000007.
std::string padded(bigint cycle) {
  char text[32];
  snprintf(text, sizeof text, "%06lld", static_cast<long long>(cycle));
  return text;
}

}  // namespace

void advance_cycles(LAMMPS *lmp, int narg, char **arg) {
  const std::vector<std::string> words = kept(narg, arg);
  if (words.size() < 5 || words[1] != "steps" || words[3] != "block") stop_with_error(lmp, CYCLES_EXPECTED);
  const bigint cycles = whole_number(lmp, words[0]), steps = whole_number(lmp, words[2]);
  const bigint block = whole_number(lmp, words[4]);
  if (block < 1 || steps < block || steps % block)
    stop_with_error(lmp, "advance_cycles: a cycle must be a whole number of blocks");
  const std::vector<Due> rules = parse_due(lmp, words);
  const FixStage *stage = FixStage::find(lmp);
  const bigint blocks = steps / block;
  for (bigint done = stage->step() / block + 1; done <= cycles * blocks; done++) {
    advance_block(lmp, block);
    const bigint cycle = done / blocks, part = done % blocks;
    const bool stop = stop_requested(lmp);
    for (const Due &rule : rules)
      if (part == 0 && (cycle == cycles || rule.after(cycle) || (stop && rule.checkpoint)))
        execute_all(lmp, rule, padded(cycle));
      else if (part != 0 && stop && rule.checkpoint)
        execute_all(lmp, rule, padded(cycle) + "_block" + std::to_string(part));
    if (stop && done < cycles * blocks) end_stopped(lmp);
  }
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

}  // namespace ballast
