# Each target first installs what it needs (bootstrap.sh); no environment has to be activated.
STUDY ?= workflow/studies/paper.yaml
CORES ?= 2

# passed as it is typed, blanks and dollars included
override STUDY := $(value STUDY)
export STUDY
export PATH := $(CURDIR)/.venv/bin:$(PATH)
export OMP_NUM_THREADS := 1
unexport PYTHONDONTWRITEBYTECODE
export VTK_DEFAULT_OPENGL_WINDOW := vtkEGLRenderWindow

.PHONY: run verification validation test quick slurm bench mutants drills fuzz check lock docs reference ready

# the answer of the atlas first, if the study has it next to simulated damping; then the study
run: ready
	-@python -m pidpanel.workflow.first_answer "$$STUDY" $(CORES)
	pidpanel run "$$STUDY" -j$(CORES)

# numbers beside closed forms and published solutions; results/verification
verification: ready
	pytest -n $(CORES) --dist worksteal -m verification tests/verification

# experiments that others made; results/validation
validation: ready
	pytest -n $(CORES) --dist worksteal -m validation tests/verification

# a file, or a folder whose tests share results, stays in one process (tests/conftest.py)
# a process that dies ends the run: xdist would wait for its group for ever
# one process more than cores: each waits a fifth of its time for processes that it has started
test: ready
	pytest -n $$(($(CORES) + 1)) --max-worker-restart 0 --dist loadgroup --no-loadscope-reorder

# a minute: the stages without solver, workflow and pages
quick: ready
	pytest -n $(CORES) --dist loadgroup --no-loadscope-reorder -m "not liggghts and not slow" \
	    tests/coupled tests/coupon tests/damping tests/panel tests/sound tests/study

# a study through a Slurm of one node on this machine (as root, from Debian packages)
slurm: ready
	tests/slurm/one_node.sh up
	pytest -m slurm -n 0 tests/slurm

# what each stage costs beside its peer or floor
bench: ready
	python benchmarks/stages.py

# changes formulas one at a time and lists the changes that no test catches (benchmarks/mutants.md)
MUTANTS ?=
mutants: ready
	uv run --active --no-project --with mutmut mutmut run --max-children $(CORES) $(MUTANTS)
	uv run --active --no-project --with mutmut mutmut results

# what can go wrong, at random moments, with real LIGGGHTS: forty minutes on two cores, writes benchmarks/drills.md
REPEATS ?= 20
drills: ready
	python tests/drills --repeats $(REPEATS) --write

# garbled files, other ones each time
FUZZ ?= 5000
fuzz: ready
	PIDPANEL_FUZZ=$(FUZZ) pytest -q -n0 tests/fuzz

check: ready
	ruff check
	ruff format --check
	snakefmt --check Snakefile workflow
	mypy
	snakemake --lint --configfile "$$STUDY"

# requirements.lock anew from pyproject.toml, with the newest versions that fit together
lock: ready
	uv pip compile pyproject.toml --all-extras --universal --python-version 3.11 \
	    --generate-hashes --no-emit-index-url --upgrade -o requirements.lock

# the documents as pages, build/docs/index.html; a broken link is an error
docs: ready
	python -m sphinx -q -W --keep-going -b html docs build/docs

# what is made from the models and checked in: the JSON schema, reference pages of keys and columns
reference: ready
	python docs/reference_pages.py

ready:
	@bash bootstrap.sh
