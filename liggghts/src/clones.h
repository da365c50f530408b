// Hot functions are compiled for several generations of processors; the best is chosen at start. Without contraction
// (-ffp-contract=off) every generation gives the same digits: each operation is rounded as IEEE 754 says.
#ifndef BALLAST_CLONES_H
#define BALLAST_CLONES_H

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define BALLAST_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define BALLAST_CLONES
#endif

#endif
