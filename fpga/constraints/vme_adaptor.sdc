# Generated from fpga/limits.toml by fpga/limits.py; do not edit. Top: vme_adaptor
create_clock -name clk -period 41.667 [get_ports {clk}]
# 500 ns from command to data, less 3 clocks, buffers and the card
set_input_delay -clock clk -max 11.667 [get_ports {pc_d[*]}]
set_input_delay -clock clk -min 0.000 -add_delay [get_ports {pc_d[*]}]
set_max_delay -from [get_ports {pc_d[*]}] -to [all_registers] 30.000
# DTACK* and its data leave together
set_output_delay -clock clk -max 11.667 [get_ports {vme_dtack_oe_n vme_irq_oe_n[*]}]
set_output_delay -clock clk -min 0.000 -add_delay [get_ports {vme_dtack_oe_n vme_irq_oe_n[*]}]
# half a clock: address and data stand a clock before commands
set_output_delay -clock clk -max 21.667 [get_ports {pc_a[*] pc_ale pc_ior_n pc_iow_n pc_d[*] pc_d_dir pc_d_oe_n}]
set_output_delay -clock clk -min 0.000 -add_delay [get_ports {pc_a[*] pc_ale pc_ior_n pc_iow_n pc_d[*] pc_d_dir pc_d_oe_n}]
# off the bus 30 ns after the strobes, before the next cycle's
set_max_delay -from [get_ports {vme_ds0_n vme_ds1_n}] -to [get_ports {vme_d_oe_n vme_dtack_oe_n}] 30.000
# the brakes' gate
set_max_delay -from [get_ports {estop_n cable_n pc_power pc_irq[*]}] -to [get_ports {brake_release}] 60.000
# AS* clocks what tells whose cycle it is
create_clock -name vme_as_n -period 110.000 [get_ports {vme_as_n}]
set_input_delay -clock vme_as_n -clock_fall -max -10.000 [get_ports {vme_a[*] vme_am[*] vme_lword_n vme_iack_n}]
set_clock_groups -asynchronous -group [get_clocks vme_as_n]
# DS0* clocks WRITE* and data
create_clock -name vme_ds0_n -period 110.000 [get_ports {vme_ds0_n}]
set_input_delay -clock vme_ds0_n -clock_fall -max -10.000 [get_ports {vme_write_n vme_d_rx[*]}]
set_clock_groups -asynchronous -group [get_clocks vme_ds0_n]
# address and ALE to the commands, of a clock
set_max_skew -from [all_registers] -to [get_ports {pc_a[*] pc_ale pc_ior_n pc_iow_n}] 10.000
# The first flip-flop of each synchroniser is read by the second: rtl/lib/sync.sv
set_max_delay -from [get_registers {*|first_q*}] -to [get_registers {*|second_q*}] 10.417
