// ballast: LIGGGHTS with the contact models, load control and output of this study. Takes the options of LIGGGHTS (-in, -var, -log).
#include <mpi.h>

#include <cstdio>

#include "input.h"
#include "lammps.h"
#include "registration.h"
#include "stop_request.h"

int main(int argc, char **argv) {
  MPI_Init(&argc, &argv);
  setvbuf(stdout, NULL, _IOLBF, 0);  // a log that is whole to its last line, however the run ends
  ballast::watch_stop_signals();
  ballast::register_contact_models();
  LAMMPS_NS::LAMMPS *lmp = new LAMMPS_NS::LAMMPS(argc, argv, MPI_COMM_WORLD);
  ballast::register_styles(lmp);
  lmp->input->file();
  delete lmp;
  MPI_Finalize();
  return 0;
}
