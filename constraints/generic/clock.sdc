# @{ module }@: clock constraint, 10 ns until a device sets its own.
create_clock -name aclk -period 10.000 [get_ports aclk]
