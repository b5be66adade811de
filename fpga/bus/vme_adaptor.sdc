# SPDX-License-Identifier: Apache-2.0
# Limits at the pins of vme_adaptor, in ns: docs/hardware/fpga.md.
set pc_out {pc_a[*] pc_ale pc_ior_n pc_iow_n}
create_clock -name clk -period 41.667 [get_ports clk]

# 500 ns from command to data, less 3 clocks, buffers and the card: 30 from the pin
set_input_delay -clock clk -max 11.667 [get_ports {pc_d[*]}]
set_input_delay -clock clk -min 0 -add_delay [get_ports {pc_d[*]}]
set_max_delay -from [get_ports {pc_d[*]}] -to [all_registers] 30
# DTACK* and its data leave together: 30 to the pin
set_output_delay -clock clk -max 11.667 [get_ports {vme_dtack_oe_n vme_irq_oe_n[*]}]
set_output_delay -clock clk -min 0 -add_delay [get_ports {vme_dtack_oe_n vme_irq_oe_n[*]}]
# half a clock: address and data stand a clock before commands, which leave within 10
set_output_delay -clock clk -max 21.667 [get_ports "$pc_out pc_d[*] pc_d_dir pc_d_oe_n"]
set_output_delay -clock clk -min 0 -add_delay [get_ports "$pc_out pc_d[*] pc_d_dir pc_d_oe_n"]
set_max_skew -from [all_registers] -to [get_ports $pc_out] 10

# off the bus 30 ns after the strobes, before the next cycle's; the brakes' gate
set_max_delay -from [get_ports {vme_ds0_n vme_ds1_n}] -to [get_ports {vme_d_oe_n vme_dtack_oe_n}] 30
set_max_delay -from [get_ports {estop_n cable_n pc_power pc_irq[*]}] -to [get_ports brake_release] 60

# AS* clocks what tells whose cycle it is, DS0* WRITE* and data: 10 before they fall
create_clock -name vme_as_n -period 110 [get_ports vme_as_n]
create_clock -name vme_ds0_n -period 110 [get_ports vme_ds0_n]
set_input_delay -clock vme_as_n -clock_fall -max -10 [get_ports {vme_a[*] vme_am[*] vme_lword_n vme_iack_n}]
set_input_delay -clock vme_ds0_n -clock_fall -max -10 [get_ports {vme_write_n vme_d_rx[*]}]
set_clock_groups -asynchronous -group clk -group vme_as_n -group vme_ds0_n

# the first flip-flop of each synchroniser is read by the second: rtl/lib
set_max_delay -from [get_registers *|first_q*] -to [get_registers *|second_q*] 10.417
