# docker build -t pidpanel .
# docker run --rm -v "$PWD/results:/pidpanel/results" --user "$(id -u):$(id -g)" pidpanel
FROM debian:bookworm-slim

# USER: whoever --user names has no entry in /etc/passwd, and Snakemake asks for a name.
ENV HOME=/tmp USER=pidpanel PIP_NO_CACHE_DIR=1 UV_NO_CACHE=1 UV_COMPILE_BYTECODE=1
WORKDIR /pidpanel

# What the environment rests on, before the sources, so that their changes do not make it anew.
COPY bootstrap.sh pyproject.toml requirements.lock LICENSE README.md ./
RUN mkdir -p src/pidpanel \
    && bash bootstrap.sh \
    && rm -rf /var/lib/apt/lists/*

COPY . .
RUN mkdir -p results && chmod 1777 . results && useradd --no-create-home pidpanel
USER pidpanel

ENV PATH=/pidpanel/.venv/bin:$PATH \
    OMP_NUM_THREADS=1 \
    VTK_DEFAULT_OPENGL_WINDOW=vtkEGLRenderWindow
ENTRYPOINT ["snakemake"]
CMD ["-j2", "--configfile", "workflow/studies/paper.yaml"]
