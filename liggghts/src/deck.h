// Commands of a deck, executed from within another command.
#ifndef BALLAST_DECK_H
#define BALLAST_DECK_H

#include <string>
#include <vector>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace ballast {

/// Arguments of a command, kept: executing another command overwrites those that LIGGGHTS holds.
std::vector<std::string> kept(int narg, char **arg);

/// Execute a command as if it stood in the deck; `include FILE` executes the lines of FILE, which may not jump.
void execute(LAMMPS_NS::LAMMPS *lmp, const std::string &command);

/// The command with `${name}` replaced by `value` everywhere.
std::string with_value(std::string command, const std::string &name, const std::string &value);

}  // namespace ballast

#endif
