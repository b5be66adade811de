# SPDX-License-Identifier: Apache-2.0
# Limits at the pins of isa_mark1, in ns: docs/hardware/fpga.md.
set bus {isa_a[*] isa_aen isa_d[*] isa_ior_n isa_iow_n}
set sampled "$bus isa_reset_drv isa_drq[*] enc_a[*] enc_b[*] enc_i[*] enable_n[*]"
set data {isa_d[*] isa_d_dir isa_d_oe_n}
set spi {spi_sclk adc_cs_n adc_din dac_sync_n dac_din dac_ldac_n}
create_clock -name clk -period 41.667 [get_ports clk]

# synchronised, address and data with it: 20 from the pin, a clock of 41 between them and a command
set_input_delay -clock clk -max 21.667 [get_ports $sampled]
set_input_delay -clock clk -min 0 -add_delay [get_ports $sampled]
set_max_delay -from [get_ports $sampled] -to [all_registers] 20
set_max_skew -from [get_ports $bus] -to [all_registers] 10
# 292 ns from IOR# to data, 158 to spare; half of SPI's 1 MHz less 475: 25 to the pin
set_output_delay -clock clk -max 16.667 [get_ports "$data $spi"]
set_output_delay -clock clk -min 0 -add_delay [get_ports "$data $spi"]
# off the bus with IOR#
set_max_delay -from [get_ports isa_ior_n] -to [get_ports isa_d_oe_n] 25

# the first flip-flop of each synchroniser is read by the second: rtl/lib
set_max_delay -from [get_registers *|first_q*] -to [get_registers *|second_q*] 10.417
