# Ballast under cyclic load, in YADE and in LIGGGHTS. `make` alone prints what there is.

SCENARIO  ?= linear-mu0.8
VARIANT   ?=
CODE      ?= liggghts
PROFILE   ?= demo
SEED      ?= 1
NP        ?= 1
RESULTS   ?= results
CYCLES    ?=
BED       ?=
REDO      ?=
SCENARIOS ?=
CASE      ?= docs/examples/impact.toml
TIMES     ?= 25
PYTHON    ?= python3

# Values reach the shell through the environment, as they were typed: neither make nor the shell reads them as code.
VARIABLES := SCENARIO VARIANT CODE PROFILE SEED NP RESULTS CYCLES BED REDO SCENARIOS CASE TIMES PYTHON
$(foreach name,$(VARIABLES),$(eval override export $(name) := $$(value $(name))))
quoted     = '$(subst ','\'',$1)'

ANALYSIS := .venv/bin/python -m analysis
STAMP    := .venv/installed
VARIED   := $${VARIANT:+--variant="$$VARIANT"}
FILE     := $${SCENARIOS:+--scenarios="$$SCENARIOS"}
AGAIN    := $${REDO:+--redo}
WHICH    := $(VARIED) --code="$$CODE" --profile="$$PROFILE" --seed="$$SEED" --results="$$RESULTS"
OPTIONS  := --profile="$$PROFILE" --seed="$$SEED" --ranks="$$NP" --results="$$RESULTS" $${CYCLES:+--cycles="$$CYCLES"} \
            $${BED:+--bed="$$BED"} $(FILE)

.DEFAULT_GOAL := help
.PHONY: help setup demo run prepare study status compare report findings readme docs view unload keep verify impact chung-ooi mutations sanitize reference calibrate timestep bench \
        test torture clean distclean distclean-run FORCE

help: ## this list
	@awk 'BEGIN { FS = ":.*## " } /^##/ { printf "\n%s\n", substr($$0, 4) } \
	      /^[a-z%-]+:.*## / { printf "  make %-22s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)
	@printf '\nVariables (now):\n  SCENARIO=%s  VARIANT=%s  CODE=%s  PROFILE=%s  SEED=%s  NP=%s  RESULTS=%s  CYCLES=%s  BED=%s\n' \
	    "$$SCENARIO" "$$VARIANT" "$$CODE" "$$PROFILE" "$$SEED" "$$NP" "$$RESULTS" "$$CYCLES" "$$BED"
	@echo '  PROFILE=demo is the end of the bed next to the plates (minutes); PROFILE=full is the bed of the paper (hours).'
	@echo '  A run that was stopped goes on when the same command is given again.'

## Simulations
demo: setup ## the end of the bed in both codes: linear, nonlinear, nonlinear by PFC's servo; and the report (minutes)
	@$(MAKE) --no-print-directory -j2 $(DEMO_YADE) $(DEMO_LIGGGHTS) PROFILE=demo
	@$(ANALYSIS) report --demo --results="$$RESULTS"

# Both codes load one bed, which LIGGGHTS packs. YADE takes ten times as long: it runs fewer cycles, and its runs begin
# first, so that two cores end together.
DEMO_YADE_CYCLES := 3
DEMO_RUNS     := linear-mu0.8 nonlinear-en1.0 nonlinear-en1.0+servo
DEMO_YADE     := $(DEMO_RUNS:%=demo-yade-%)
DEMO_LIGGGHTS := $(DEMO_RUNS:%=demo-liggghts-%)
.PHONY: demo-bed $(DEMO_YADE) $(DEMO_LIGGGHTS)
demo-bed: setup
	@$(ANALYSIS) run linear-mu0.8 --code=liggghts --until=packing --progress=lines $(OPTIONS)
$(DEMO_YADE): demo-yade-%: demo-bed
	@CYCLES="$${CYCLES:-$(DEMO_YADE_CYCLES)}"; $(ANALYSIS) run $*+same-bed --code=yade --progress=lines $(OPTIONS)
$(DEMO_LIGGGHTS): demo-liggghts-%: demo-bed
	@$(ANALYSIS) run $* --code=liggghts --progress=lines $(OPTIONS)

run: setup ## one scenario: make run SCENARIO=linear-mu0.8 CODE=yade PROFILE=full CYCLES=20 SEED=2
	@$(ANALYSIS) run $(VARIED) --code="$$CODE" $(OPTIONS) $(AGAIN) -- "$$SCENARIO"
prepare: setup ## write a run's folder and print the commands of its stages, to be started by hand
	@$(ANALYSIS) prepare $(VARIED) --code="$$CODE" $(OPTIONS) -- "$$SCENARIO"

# For any scenario of scenarios.toml: make liggghts-linear-mu0.8, make yade-nonlinear-en1.0 ...
yade-%: setup FORCE ## the same by name, for every scenario of scenarios.toml: make yade-nonlinear-en1.0 PROFILE=full
	@$(ANALYSIS) run $(VARIED) --code=yade $(OPTIONS) $(AGAIN) -- $(call quoted,$*)
liggghts-%: setup FORCE ## likewise: make liggghts-linear-mu0.8 CYCLES=20
	@$(ANALYSIS) run $(VARIED) --code=liggghts $(OPTIONS) $(AGAIN) -- $(call quoted,$*)

study: setup ## all runs of the study that are not done yet, two at a time: make -j2 study
	@$(ANALYSIS) study --make --ranks="$$NP" --results="$$RESULTS" $(FILE) | $(MAKE) --no-print-directory --keep-going -f - study

status: $(STAMP) ## all runs: stage, cycle, speed, time left, tracking error, state
	@$(ANALYSIS) status --results="$$RESULTS"

## Results
compare: $(STAMP) ## rebuild report/index.html from the runs that exist
	@$(ANALYSIS) report --results="$$RESULTS"
report: compare ## the same
findings: $(STAMP) ## what the runs say, as tables: report/findings/*.csv
	@$(ANALYSIS) findings --results="$$RESULTS"
readme: $(STAMP) ## the README's section on results, from the kept runs
	@$(ANALYSIS) readme
docs: $(STAMP) ## docs/ and PARAMETERS.md: the sketch and what follows from scenarios.toml and the code
	@$(ANALYSIS) docs
view: $(STAMP) ## pictures and ParaView files of one run: make view SCENARIO=... CODE=...
	@$(ANALYSIS) view --code="$$CODE" --profile="$$PROFILE" --seed="$$SEED" --results="$$RESULTS" -- "$$SCENARIO$${VARIANT:++$$VARIANT}"
unload: setup ## how much of a run's settlement springs back under its least load: make unload SCENARIO=... PROFILE=full
	@$(ANALYSIS) unload $(WHICH) -- "$$SCENARIO"
keep: $(STAMP) ## put a run's normalised results into the repository: make keep SCENARIO=... CODE=... PROFILE=full
	@$(ANALYSIS) keep $(WHICH) -- "$$SCENARIO"
reference: $(STAMP) ## the reference curves and their state
	@$(ANALYSIS) reference

## Checks
test: setup ## all tests, with both codes
	@.venv/bin/python -m pytest
torture: setup ## kill and stop runs of the demo bed TIMES times per code and law: they end with the same files (an hour)
	@.venv/bin/python tests/torture.py --times="$$TIMES"
verify: setup ## contact laws and clumps of both codes against closed forms
	@$(ANALYSIS) verify
impact: setup ## any impact of two bodies in both codes: make impact CASE=docs/examples/impact.toml, or CASE=<scenario>
	@$(ANALYSIS) impact -- "$$CASE"
chung-ooi: setup ## the eight benchmark impacts of Chung and Ooi (2011) in both codes, a figure each
	@$(ANALYSIS) impact -- docs/examples/chung-ooi
mutations: setup ## wrong laws that the verification must notice: which case catches which (half an hour)
	@$(ANALYSIS) mutations
sanitize: setup ## the verification of LIGGGHTS with address and undefined-behaviour checks
	@$(MAKE) --no-print-directory -C liggghts sanitize
	@$(ANALYSIS) verify --code liggghts --host liggghts/build/ballast-sanitize --out report/sanitize
calibrate: setup ## clumps, porosity and settlement over lattice gaps and clump aspects (hours)
	@$(ANALYSIS) calibrate --results="$$RESULTS"
timestep: setup ## the full bed at half the paper's time step up to 0.8 of the critical one, 20 cycles each (hours)
	@$(ANALYSIS) timestep --results="$$RESULTS"
bench: setup ## speeds in processor time: ours, stock LIGGGHTS, a stock YADE script: make bench PROFILE=full
	@$(ANALYSIS) bench --profile="$$PROFILE" --results="$$RESULTS"

## Housekeeping
setup: ## packages, Python environment and LIGGGHTS host, where missing
	@bash setup.sh packages
	@$(MAKE) --silent $(STAMP)
	@$(MAKE) --silent -C liggghts

# An environment whose Python was upgraded or removed below it still has its stamp: it is tried, not believed.
$(STAMP): pyproject.toml setup.sh $(if $(shell bash setup.sh works 2>&1),FORCE)
	@bash setup.sh environment

clean: ## what was built; never results
	rm -rf liggghts/build .pytest_cache build *.egg-info
	find . -name __pycache__ -not -path './.venv/*' -exec rm -rf {} +

distclean-run: $(STAMP) ## delete one run, after asking: make distclean-run SCENARIO=... CODE=... PROFILE=... SEED=...
	@$(ANALYSIS) delete $(WHICH) -- "$$SCENARIO"

distclean: ## all that is not in the repository: results, report, .venv; asks first
	@printf 'Delete %s, report, .venv and all that was built? Type yes: ' "$$RESULTS"; read -r answer; test "$$answer" = yes
	@$(MAKE) --no-print-directory clean
	rm -rf -- "$$RESULTS" report .venv
