// Makes contact models, fixes and commands known to an unchanged libliggghts, through its factories and style tables.
#include "registration.h"

#include <mpi.h>

#include <map>
#include <string>

// LIGGGHTS' headers need this order
#include "lammps.h"
#include "modify.h"
#include "fix.h"
#include "atom.h"
#include "comm.h"
#include "update.h"
#include "force.h"
#include "neighbor.h"
#include "neigh_list.h"
#include "memory.h"
#include "error.h"
#include "input.h"
#include "granular_pair_style.h"
#include "contact_models.h"

#include "commands.h"
#include "fix_bonds.h"
#include "fix_history.h"
#include "fix_load_control.h"
#include "fix_multisphere_damped.h"
#include "fix_probe.h"
#include "fix_stage.h"
#include "fix_wall.h"
#include "pair_ballast.h"

using namespace LAMMPS_NS;
using namespace LIGGGHTS;
using namespace LIGGGHTS::ContactModels;

namespace {

template <bool HYSTERETIC>
PairStyles::IGranularPairStyle *create_pair(LAMMPS *lmp, PairGran *, int64_t) {
  return new ballast::PairBallast(lmp, HYSTERETIC);
}

// The style tables are not public. An explicit template instantiation may name them all the same (access is not checked
// there).
typedef std::map<std::string, Fix *(*)(LAMMPS *, int, char **)> FixTable;
typedef std::map<std::string, void (*)(LAMMPS *, int, char **)> CommandTable;

struct FixTableKey {
  typedef FixTable *Modify::*Member;
  friend Member member_of(FixTableKey);
};

struct CommandTableKey {
  typedef CommandTable *Input::*Member;
  friend Member member_of(CommandTableKey);
};

template <typename Key, typename Key::Member MEMBER>
struct Expose {
  friend typename Key::Member member_of(Key) { return MEMBER; }
};

template struct Expose<FixTableKey, &Modify::fix_map>;
template struct Expose<CommandTableKey, &Input::command_map>;

template <typename Style>
Fix *create_fix(LAMMPS *lmp, int narg, char **arg) {
  return new Style(lmp, narg, arg);
}

}  // namespace

namespace ballast {

void register_contact_models() {
  Factory &models = Factory::instance();
  models.addNormalModel("ballast/linear", LINEAR_ID);
  models.addNormalModel("ballast/hysteretic", HYSTERETIC_ID);
  models.addTangentialModel("ballast/slip", SLIP_ID);
  PairStyles::Factory &pairs = PairStyles::Factory::instance();
  pairs.addStyle("gran", static_cast<int>(PairBallast::hashcode_of(false)), &create_pair<false>);
  pairs.addStyle("gran", static_cast<int>(PairBallast::hashcode_of(true)), &create_pair<true>);
}

void register_styles(LAMMPS *lmp) {
  FixTable &fixes = *(lmp->modify->*member_of(FixTableKey()));
  fixes["multisphere/damped"] = &create_fix<FixMultisphereDamped>;
  fixes["ballast/wall"] = &create_fix<FixWall>;
  fixes["ballast/probe"] = &create_fix<FixProbe>;
  fixes["ballast/stage"] = &create_fix<FixStage>;
  fixes["ballast/load"] = &create_fix<FixLoadControl>;
  fixes["ballast/history"] = &create_fix<FixHistory>;
  fixes["ballast/bonds"] = &create_fix<FixBonds>;

  CommandTable &commands = *(lmp->input->*member_of(CommandTableKey()));
  commands["place"] = &place;
  commands["remove_outside"] = &remove_outside;
  commands["write_bed"] = &write_bed;
  commands["write_contacts"] = &write_contacts;
  commands["write_bonds"] = &write_bonds;
  commands["write_checkpoint"] = &write_checkpoint;
  commands["advance"] = &advance;
  commands["advance_to_rest"] = &advance_to_rest;
  commands["advance_cycles"] = &advance_cycles;
  commands["for_each"] = &for_each;
  commands["pair_property"] = &pair_property;
}

}  // namespace ballast
