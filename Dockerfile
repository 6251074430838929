# docker build -t pidpanel .
# docker run --rm -v "$PWD/results:/pidpanel/results" --user "$(id -u):$(id -g)" pidpanel
FROM debian:bookworm-slim

ENV HOME=/tmp PIP_NO_CACHE_DIR=1
WORKDIR /pidpanel

# What the environment needs, before the sources, so that their changes leave it alone.
COPY bootstrap.sh pyproject.toml requirements.lock LICENSE ./
RUN mkdir -p src/pidpanel results \
    && bash bootstrap.sh \
    && rm -rf /var/lib/apt/lists/*

COPY . .
RUN useradd --uid 1000 pidpanel && chown -R pidpanel . && rm -rf /tmp/*
USER pidpanel

ENV PATH=/pidpanel/.venv/bin:$PATH \
    OMP_NUM_THREADS=1 \
    VTK_DEFAULT_OPENGL_WINDOW=vtkEGLRenderWindow
ENTRYPOINT ["snakemake", "--workflow-profile", "workflow/profiles/default"]
CMD ["-j2", "--configfile", "workflow/studies/paper.yaml"]
