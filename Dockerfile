# docker build -t pidpanel .
# docker run --rm -v "$PWD:/work" --user "$(id -u):$(id -g)" pidpanel pidpanel new mine.yaml
# docker run --rm -v "$PWD:/work" --user "$(id -u):$(id -g)" pidpanel pidpanel run mine.yaml
#
# The folder of the studies is /work; docs/cluster.md has more.
#
# pidpanel is MIT; gmsh, which it imports, and LIGGGHTS, which it loads, are GPL-2.0-or-later. Who
# passes the image on does so under the GPL and offers the sources of all of it: docs/cite.md.
FROM debian:bookworm-slim

# USER: whoever --user names has no entry in /etc/passwd, and Snakemake asks for a name.
ENV HOME=/tmp USER=pidpanel PIP_NO_CACHE_DIR=1 UV_NO_CACHE=1 UV_COMPILE_BYTECODE=1
WORKDIR /pidpanel

# The environment, from the lock and from what makes it, and from nothing else: an edit of the
# sources or of the README leaves this layer as it is.
COPY bootstrap.sh requirements.lock ./
RUN ENVIRONMENT_ONLY=1 bash bootstrap.sh \
    && rm -rf /var/lib/apt/lists/*

COPY . .
RUN SYSTEM_READY=1 bash bootstrap.sh \
    && useradd --no-create-home pidpanel && mkdir -m 1777 /work
USER pidpanel
WORKDIR /work

ENV PATH=/pidpanel/.venv/bin:$PATH \
    OMP_NUM_THREADS=1 \
    VTK_DEFAULT_OPENGL_WINDOW=vtkEGLRenderWindow
CMD ["pidpanel", "run", "paper.yaml"]
