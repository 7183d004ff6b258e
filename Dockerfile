# lightcook in a container: docker build -t lightcook .   (podman build and buildah bud take the same file)
#   docker run --rm -v "$PWD:/work" -u "$(id -u):$(id -g)" lightcook cook my/scene.toml -o out/my
# docs/guide/building.md says more. The image holds the Debian package and what it depends on, no compiler, and runs without rights.
ARG BASE=debian:12

FROM ${BASE} AS build
WORKDIR /src
# Packages before sources: an edit of the sources keeps this layer.
COPY dev ./
COPY viewer/package.json viewer/package-lock.json viewer/
RUN ./dev setup build package
COPY . ./
RUN ./dev package && mkdir /package && cp build/release/packages/lightcook_*.deb /package/

FROM ${BASE}
COPY --from=build /package /package
RUN apt-get -q update \
    && DEBIAN_FRONTEND=noninteractive apt-get -q -y --no-install-recommends install /package/lightcook_*.deb \
    && rm -rf /package /var/lib/apt/lists/* \
    && install -d -m 1777 /work /var/cache/lightcook
# Any user may write here, also one that -u names and that has no home. Mount a volume at /var/cache/lightcook to keep results between runs.
ENV LIGHTCOOK_CACHE=/var/cache/lightcook
# A number, so that a cluster can see that it is not root.
USER 10001:10001
WORKDIR /work
ENTRYPOINT ["lightcook"]
CMD ["--help"]
