"""`vehicle-gateway check-config`: whether a configuration describes a car that can be driven."""
