# `docker buildx bake -f deploy/images/docker-bake.hcl` builds ground, vehicle and sim for amd64 and arm64.

variable "PACKAGES" { default = "target/packages" }
variable "REGISTRY" { default = "" }
variable "VERSION" { default = "0.1.0" }
variable "BASE" { default = "docker.io/library/debian:bookworm-slim" }

group "default" { targets = ["ground", "vehicle", "sim"] }

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

target "sim" {
  inherits = ["_all"]
  target   = "sim"
  tags     = ["${REGISTRY}skein-sim:${VERSION}"]
}
