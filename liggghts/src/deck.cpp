#include "deck.h"

#include <fstream>
#include <sstream>

#include "commands.h"
#include "input.h"
#include "lammps.h"
#include "stop_with_error.h"

using namespace LAMMPS_NS;

namespace ballast {

std::vector<std::string> kept(int narg, char **arg) { return std::vector<std::string>(arg, arg + narg); }

void execute(LAMMPS *lmp, const std::string &command) {
  std::istringstream words(command);
  std::string first, path;
  if (!(words >> first >> path) || first != "include") {
    lmp->input->one(command.c_str());
    return;
  }
  // LIGGGHTS' own include would be read after the command that is being executed
  std::ifstream file(path);
  if (!file) stop_with_error(lmp, path + ": cannot be read; decks are started from the top of the repository");
  std::string line, part;
  while (std::getline(file, part)) {
    line += part;
    if (!line.empty() && line.back() == '&') {
      line.pop_back();
      continue;
    }
    lmp->input->one(line.c_str());
    line.clear();
  }
}

std::string with_value(std::string command, const std::string &name, const std::string &value) {
  const std::string reference = "${" + name + "}";
  for (std::size_t at = command.find(reference); at != std::string::npos;
       at = command.find(reference, at + value.size()))
    command.replace(at, reference.size(), value);
  return command;
}

void for_each(LAMMPS *lmp, int narg, char **arg) {
  const std::vector<std::string> words = kept(narg, arg);
  std::size_t first = 2;
  while (first < words.size() && words[first] != "do") first++;
  if (words.size() < 4 || words[1] != "in" || first + 1 >= words.size())
    stop_with_error(lmp, "for_each: expects NAME in ITEM ... do \"COMMAND\" ...");
  for (std::size_t item = 2; item < first; item++)
    for (std::size_t n = first + 1; n < words.size(); n++) execute(lmp, with_value(words[n], words[0], words[item]));
}

void pair_property(LAMMPS *lmp, int narg, char **arg) {
  const std::vector<std::string> words = kept(narg, arg);
  const bool alike = words.size() == 4 && words[2] == "all";
  const bool by_pair = (words.size() == 6 || (words.size() == 8 && words[6] == "sides")) && words[2] == "particles" &&
                       words[4] == "walls";
  if (!alike && !by_pair)
    stop_with_error(lmp,
                    "pair_property: expects ID NAME all VALUE, or ID NAME particles VALUE walls VALUE [sides VALUE]");
  const std::string particles = words[3], walls = alike ? particles : words[5];
  const std::string sides = words.size() == 8 ? words[7] : walls;
  std::string command = "fix " + words[0] + " all property/global " + words[1] + " peratomtypepair 3";
  for (const std::string &value : {particles, walls, sides, walls, walls, walls, sides, walls, sides})
    command += " " + value;
  lmp->input->one(command.c_str());
}

}  // namespace ballast
