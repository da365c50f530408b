#include "stop_with_error.h"

#include <mpi.h>

#include <cstdio>
#include <cstdlib>

#include "comm.h"
#include "lammps.h"

namespace ballast {

void stop_with_error(LAMMPS_NS::LAMMPS *lmp, const std::string &text) {
  if (lmp->comm->me != 0) MPI_Barrier(lmp->world);  // until rank 0 has spoken and ends all
  fflush(stdout);
  fprintf(stderr, "ERROR: %s\n", text.c_str());
  fflush(NULL);
  if (lmp->comm->nprocs > 1) MPI_Abort(lmp->world, 1);  // the other ranks may be elsewhere
  MPI_Finalize();
  std::exit(1);
}

}  // namespace ballast
