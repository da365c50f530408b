// One clear line, then a non-zero exit status.
#ifndef BALLAST_STOP_WITH_ERROR_H
#define BALLAST_STOP_WITH_ERROR_H

#include <string>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace ballast {

/// Print `ERROR: text` and end all ranks with exit status 1. To be called by rank 0 or by all.
[[noreturn]] void stop_with_error(LAMMPS_NS::LAMMPS *lmp, const std::string &text);

}  // namespace ballast

#endif
