# `docker buildx bake -f deploy/images/docker-bake.hcl` builds ground, vehicle and sim for amd64 and arm64, and the vehicles of boards with cameras of their own for arm64.

variable "PACKAGES" { default = "target/packages" }
variable "REGISTRY" { default = "" }
variable "VERSION" { default = "0.1.0" }
variable "BASE" { default = "docker.io/library/debian:bookworm-slim" }

variable "JETSON_BASE" { default = "nvcr.io/nvidia/l4t-base:r36.2.0" }

group "default" { targets = ["ground", "vehicle", "vehicle-pi", "vehicle-jetson", "sim"] }

target "_all" {
  context    = PACKAGES
  dockerfile = "${BAKE_CMD_CONTEXT}/deploy/images/Dockerfile"
  platforms  = ["linux/amd64", "linux/arm64"]
  args       = { BASE = BASE }
  labels     = { "org.opencontainers.image.version" = VERSION }
}

target "ground" {
  inherits = ["_all"]
  target   = "ground"
  tags     = ["${REGISTRY}skein-ground:${VERSION}"]
}

target "vehicle" {
  inherits = ["_all"]
  target   = "vehicle"
  tags     = ["${REGISTRY}skein-vehicle:${VERSION}"]
}

target "vehicle-pi" {
  inherits  = ["vehicle"]
  platforms = ["linux/arm64"]
  args      = { BASE = BASE, BOARD = "pi" }
  tags      = ["${REGISTRY}skein-vehicle-pi:${VERSION}"]
}

target "vehicle-jetson" {
  inherits  = ["vehicle"]
  platforms = ["linux/arm64"]
  args      = { BASE = BASE, JETSON_BASE = JETSON_BASE, BOARD = "jetson" }
  tags      = ["${REGISTRY}skein-vehicle-jetson:${VERSION}"]
}

target "sim" {
  inherits = ["_all"]
  target   = "sim"
  tags     = ["${REGISTRY}skein-sim:${VERSION}"]
}
