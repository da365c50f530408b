#!/bin/sh
# YADE with the modules of this repository, on memory that suits it; all arguments go to `yade`.
#
#   yade/launch.sh -j1 -n -x yade/cyclic.py RUN_FOLDER CHECKPOINT
#
# YADE does not tell a script where it lies (__file__ is YADE's own program): Python finds the folders yade and analysis
# through PYTHONPATH.
# A step of the full bed waits for memory: bodies and contacts are some 80 000 small objects. jemalloc keeps objects of
# one size side by side, huge pages spare most of the address translations; README.md says what each is worth. Without
# the package libjemalloc2 the system's own allocator takes huge pages. Results do not depend on it.

here=$(cd "$(dirname "$0")" && pwd)
export PYTHONPATH="$here:$(dirname "$here")${PYTHONPATH:+:$PYTHONPATH}"
for library in /usr/lib/*/libjemalloc.so.2; do
    if [ -e "$library" ]; then
        export LD_PRELOAD="$library${LD_PRELOAD:+:$LD_PRELOAD}"
        export MALLOC_CONF="thp:always,metadata_thp:always,narenas:1,dirty_decay_ms:-1,muzzy_decay_ms:-1"
        break
    fi
done
export GLIBC_TUNABLES="glibc.malloc.hugetlb=1"
exec yade "$@"
