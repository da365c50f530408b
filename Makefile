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
SCENARIOS ?=
CASE      ?= tests/impact.toml

PYTHON   ?= python3
ANALYSIS := .venv/bin/python -m analysis
STAMP    := .venv/installed
empty    :=
space    := $(empty) $(empty)
comma    := ,
# scenario and variants as folders are called: linear-mu0.8+same-bed+servo
ID        = $(subst $(space),+,$(strip $(SCENARIO) $(sort $(subst $(comma), ,$(subst +, ,$(VARIANT))))))
OPTIONS   = --profile $(PROFILE) --seed $(SEED) --ranks $(NP) --results $(RESULTS) $(if $(CYCLES),--cycles $(CYCLES)) $(if $(BED),--bed $(BED)) $(if $(SCENARIOS),--scenarios $(SCENARIOS))
VARIED    = $(if $(VARIANT),--variant $(VARIANT))
FOLDER    = $(RESULTS)/$(PROFILE)/$(ID)/$(CODE)$(if $(filter-out 1,$(SEED)),-seed$(SEED))

.DEFAULT_GOAL := help
.PHONY: help setup demo demo-yade demo-liggghts run study status compare report findings view keep verify impact mutations sanitize reference calibrate bench \
        test clean distclean distclean-run FORCE

help: ## this list
	@awk 'BEGIN { FS = ":.*## " } /^##/ { printf "\n%s\n", substr($$0, 4) } \
	      /^[a-z%-]+:.*## / { printf "  make %-22s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)
	@printf '\nVariables (now):\n  SCENARIO=%s  VARIANT=%s  CODE=%s  PROFILE=%s  SEED=%s  NP=%s  RESULTS=%s  CYCLES=%s  BED=%s\n' \
	    '$(SCENARIO)' '$(VARIANT)' '$(CODE)' '$(PROFILE)' '$(SEED)' '$(NP)' '$(RESULTS)' '$(CYCLES)' '$(BED)'
	@echo '  PROFILE=demo is a slice of the bed (minutes); PROFILE=full is the bed of the paper (hours).'
	@echo '  A run that was stopped goes on when the same command is given again.'

## Simulations
demo: setup ## both codes, linear-mu0.8 and nonlinear-en1.0, small bed, and the report (minutes)
	@$(MAKE) --no-print-directory -j2 demo-yade demo-liggghts PROFILE=demo
	@$(ANALYSIS) report --results $(RESULTS)

demo-yade demo-liggghts: demo-%: setup
	@$(ANALYSIS) run linear-mu0.8 --code $* --progress lines $(OPTIONS)
	@$(ANALYSIS) run nonlinear-en1.0 --code $* --progress lines $(OPTIONS)

run: setup ## one scenario: make run SCENARIO=linear-mu0.8 CODE=yade PROFILE=full CYCLES=20 SEED=2
	@$(ANALYSIS) run $(SCENARIO) $(VARIED) --code $(CODE) $(OPTIONS)

# For any scenario of scenarios.toml: make liggghts-linear-mu0.8, make yade-nonlinear-en1.0 ...
yade-%: setup FORCE ## the same by name, for every scenario of scenarios.toml: make yade-nonlinear-en1.0 PROFILE=full
	@$(ANALYSIS) run $* $(VARIED) --code yade $(OPTIONS)
liggghts-%: setup FORCE ## likewise: make liggghts-linear-mu0.8 CYCLES=20
	@$(ANALYSIS) run $* $(VARIED) --code liggghts $(OPTIONS)

study: setup ## all runs of the study that are not done yet, two at a time: make -j2 study
	@$(ANALYSIS) study --make --ranks $(NP) --results $(RESULTS) $(if $(SCENARIOS),--scenarios $(SCENARIOS)) | $(MAKE) --no-print-directory --keep-going -f - study

status: $(STAMP) ## all runs: stage, cycle, speed, time left, tracking error, state
	@$(ANALYSIS) status --results $(RESULTS)

## Results
compare: $(STAMP) ## rebuild report/index.html from the runs that exist
	@$(ANALYSIS) report --results $(RESULTS)
report: compare ## the same
findings: $(STAMP) ## what the runs say, as tables: report/findings/*.csv
	@$(ANALYSIS) findings --results $(RESULTS)
view: $(STAMP) ## pictures and ParaView files of one run: make view SCENARIO=... CODE=...
	@$(ANALYSIS) view $(ID) --code $(CODE) --profile $(PROFILE) --seed $(SEED) --results $(RESULTS)
keep: ## put a run's normalised results into the repository: make keep SCENARIO=... CODE=... PROFILE=full
	@test -f '$(FOLDER)/cycles.csv' -o -f '$(FOLDER)/stages.json' || { echo 'no results in $(FOLDER): run it first'; exit 1; }
	@mkdir -p 'reference_data/runs/$(FOLDER:$(RESULTS)/%=%)'
	@for name in run.json scenario.json stages.json cycles.csv microstructure.csv; do \
	    if test -f '$(FOLDER)'/$$name; then cp '$(FOLDER)'/$$name 'reference_data/runs/$(FOLDER:$(RESULTS)/%=%)'/; fi; done
	@echo 'kept in reference_data/runs/$(FOLDER:$(RESULTS)/%=%); git add and commit it'
reference: $(STAMP) ## the reference curves and their state
	@$(ANALYSIS) reference

## Checks
test: setup ## all tests, with both codes
	@.venv/bin/python -m pytest
verify: setup ## contact laws and clumps of both codes against closed forms
	@$(ANALYSIS) verify
impact: setup ## any impact of two bodies in both codes: make impact CASE=tests/impact.toml, or CASE=<scenario>
	@$(ANALYSIS) impact $(CASE)
mutations: setup ## wrong laws that the verification must notice: which case catches which (half an hour)
	@$(ANALYSIS) mutations
sanitize: setup ## the verification of LIGGGHTS with address and undefined-behaviour checks
	@$(MAKE) --no-print-directory -C liggghts sanitize
	@$(ANALYSIS) verify --code liggghts --host liggghts/build/ballast-sanitize --out report/sanitize
calibrate: setup ## clumps, porosity and settlement over lattice gaps and clump aspects (hours)
	@$(ANALYSIS) calibrate --results $(RESULTS)
bench: setup ## steps per second of both codes, one after the other
	@$(ANALYSIS) bench --profile $(PROFILE) --ranks $(NP) --results $(RESULTS)

## Housekeeping
setup: ## packages, Python environment and LIGGGHTS host, where missing
	@./setup.sh
	@$(MAKE) --silent $(STAMP)
	@$(MAKE) --silent -C liggghts

$(STAMP): pyproject.toml
	@test -x .venv/bin/python || $(PYTHON) -m venv .venv
	@.venv/bin/python -c 'import sys; sys.version_info >= (3, 11) or sys.exit("setup: Python 3.11 or newer is needed; give PYTHON=path")'
	@echo 'setup: installing the Python packages of pyproject.toml into .venv'
	@.venv/bin/python -m pip install --quiet --disable-pip-version-check --editable '.[test]'
	@touch $@

clean: ## what was built; never results
	rm -rf liggghts/build .pytest_cache build *.egg-info
	find . -name __pycache__ -not -path './.venv/*' -exec rm -rf {} +

distclean-run: ## delete one run, after asking: make distclean-run SCENARIO=... CODE=... PROFILE=... SEED=...
	@test -d '$(FOLDER)' || { echo 'no such run: $(FOLDER)'; exit 1; }
	@printf 'Delete %s? Type yes: ' '$(FOLDER)'; read -r answer; test "$$answer" = yes && rm -rf '$(FOLDER)'

distclean: ## all that is not in the repository: results, report, .venv; asks first
	@printf 'Delete %s, report, .venv and all that was built? Type yes: ' '$(RESULTS)'; read -r answer; test "$$answer" = yes
	@$(MAKE) --no-print-directory clean
	rm -rf '$(RESULTS)' report .venv
