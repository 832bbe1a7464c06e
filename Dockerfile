# osm2xodr with all that its commands can use:
#   docker build -t osm2xodr .
#   docker run --rm -v "$PWD:/data" -u "$(id -u):$(id -g)" osm2xodr convert area.osm --dem dem.tif -o area.xodr
FROM python:3.12.11-bookworm AS build

# With the C compiler that loops are compiled with.
COPY pyproject.toml README.md LICENSE hatch_build.py /source/
COPY src /source/src
COPY docs /source/docs
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels /source

FROM python:3.12.11-slim-bookworm

# The wheels of rasterio bring GDAL, but not the library that reads XML.
RUN apt-get update && apt-get install -y --no-install-recommends libexpat1 && apt-get clean
COPY --from=build /wheels /wheels
RUN pip install --no-cache-dir "$(echo /wheels/*.whl)[batch,check,scene]" && rm -rf /wheels
# Not root, even without -u.
RUN useradd --create-home --uid 1000 osm2xodr && install --directory --owner osm2xodr /data
USER osm2xodr
WORKDIR /data
ENTRYPOINT ["osm2xodr"]
CMD ["--help"]
