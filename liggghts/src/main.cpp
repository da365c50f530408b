// ballast: LIGGGHTS with the contact models, load control and output of this study. Takes the options of LIGGGHTS (-in,
// -var, -log).
#include <mpi.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "input.h"
#include "lammps.h"
#include "registration.h"
#include "stop_request.h"

namespace {

/// `-var ranks N` says how many ranks a run has. The mpirun of another MPI would start N runs of one rank in the same
/// folder.
void end_unless_ranks_are_as_told(int argc, char **argv) {
  int ranks;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  for (int n = 1; n + 2 < argc; n++) {
    if (strcmp(argv[n], "-var") != 0 || strcmp(argv[n + 1], "ranks") != 0 || atoi(argv[n + 2]) == ranks) continue;
    printf(
        "ERROR: %s ranks were asked for, but this process is one of %d: the mpirun that started it belongs to another MPI; put Open "
        "MPI's first in PATH\n",
        argv[n + 2], ranks);
    MPI_Finalize();
    exit(1);
  }
}

}  // namespace

int main(int argc, char **argv) {
  MPI_Init(&argc, &argv);
  setvbuf(stdout, NULL, _IOLBF, 0);  // a log that is whole to its last line, however the run ends
  end_unless_ranks_are_as_told(argc, argv);
  ballast::watch_stop_signals();
  ballast::register_contact_models();
  LAMMPS_NS::LAMMPS *lmp = new LAMMPS_NS::LAMMPS(argc, argv, MPI_COMM_WORLD);
  ballast::register_styles(lmp);
  lmp->input->file();
  delete lmp;
  MPI_Finalize();
  return 0;
}
