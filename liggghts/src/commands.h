// Commands that decks of this study may use beside those of LIGGGHTS.
#ifndef BALLAST_COMMANDS_H
#define BALLAST_COMMANDS_H

namespace LAMMPS_NS {
class LAMMPS;
}

namespace ballast {

/// place FILE radius R half_distance H mass M density RHO inertia TRANSVERSE AXIAL type T
/// Clumps of two spheres at the poses of a bed file, at rest; ids are those of the file.
void place(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// remove_outside XLO XHI YLO YHI ZLO ZHI: delete the clumps whose centre is outside.
void remove_outside(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// write_bed FILE: poses of all clumps, in the order of their ids.
void write_bed(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// write_contacts FILE: all contacts with their forces.
void write_contacts(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// write_bonds FILE: all bonds, broken ones too; where they are, or broke. Nothing in a deck without bonds.
void write_bonds(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// write_checkpoint FILE: a restart file that appears complete, or not at all.
void write_checkpoint(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

// The three that follow run in blocks of N steps. After each block they append a row of the bed's state to the file of
// `fix ballast/stage`, and see whether SIGTERM or SIGINT came to any rank: if so, the run ends with exit status 75.

/// advance STEPS [block N]: run STEPS steps.
void advance(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// advance_to_rest unbalanced_ratio R kinetic_energy E time_limit T block N [stress_tolerance S]
/// Run until the unbalanced ratio is at most R and the mean kinetic energy of a clump at most E (J), and until the mean
/// stress of every `fix ballast/load` is within the share S of its target. After T seconds of simulated time that is an
/// error.
void advance_to_rest(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// advance_cycles CYCLES steps N block M [every K "COMMAND" ...] [at CYCLE ... do "COMMAND" ...] [checkpoint K
/// "COMMAND"] Run to the end of the CYCLES-th cycle of N steps from where the stage stands. The commands of `every` are
/// executed at the end of each K-th cycle, those of `at` at the end of the cycles named, all of them at the end of the
/// last one, in the order of the deck; ${cycle} in them is the cycle, as 000007. That of `checkpoint` comes also where
/// the run is stopped: ${cycle} is 000007_block3 after three blocks of the eighth.
void advance_cycles(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// for_each NAME in ITEM ... do "COMMAND" ...: execute the commands for each item in turn, which ${NAME} in them stands
/// for, also within the name of another variable: ${plate_${plate}_block}.
void for_each(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// pair_property ID NAME particles V walls V [sides V], or pair_property ID NAME all V
/// `fix ID all property/global NAME peratomtypepair 3 ...` for types 1 (particles), 2 (walls) and 3 (end wall and side
/// walls, by default like the other walls).
void pair_property(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

}  // namespace ballast

#endif
