# Everything here sets itself up first (bootstrap.sh); nothing needs an activated environment.
STUDY ?= workflow/studies/paper.yaml
CORES ?= 2

export PATH := $(CURDIR)/.venv/bin:$(PATH)
export OMP_NUM_THREADS := 1
unexport PYTHONDONTWRITEBYTECODE
export VTK_DEFAULT_OPENGL_WINDOW := vtkEGLRenderWindow

.PHONY: run verification test mutants check lock ready

run: ready
	snakemake -j$(CORES) --configfile $(STUDY)

verification: ready
	snakemake -j$(CORES) verification

test: ready
	pytest

# small errors put into the formulas, one at a time: how many of them the tests notice
mutants: ready
	python tests/mutation --jobs $(CORES)

check: ready
	ruff check
	ruff format --check
	snakefmt --check Snakefile workflow
	mypy
	snakemake --lint --configfile $(STUDY)

# requirements.lock anew from pyproject.toml, with the newest versions that fit together
lock: ready
	uv pip compile pyproject.toml --all-extras --universal --python-version 3.11 \
	    --generate-hashes --no-emit-index-url --upgrade -o requirements.lock

ready:
	@bash bootstrap.sh
