# Generated from fpga/limits.toml by fpga/limits.py; do not edit. Top: isa_mark1
create_clock -name clk -period 41.667 [get_ports {clk}]
# synchronised, address and data with it
set_input_delay -clock clk -max 21.667 [get_ports {isa_a[*] isa_aen isa_ior_n isa_iow_n isa_reset_drv isa_drq[*] isa_d[*] enc_a[*] enc_b[*] enc_i[*] enable_n[*]}]
set_input_delay -clock clk -min 0.000 -add_delay [get_ports {isa_a[*] isa_aen isa_ior_n isa_iow_n isa_reset_drv isa_drq[*] isa_d[*] enc_a[*] enc_b[*] enc_i[*] enable_n[*]}]
set_max_delay -from [get_ports {isa_a[*] isa_aen isa_ior_n isa_iow_n isa_reset_drv isa_drq[*] isa_d[*] enc_a[*] enc_b[*] enc_i[*] enable_n[*]}] -to [all_registers] 20.000
# 292 ns from IOR# to data, 158 to spare
set_output_delay -clock clk -max 16.667 [get_ports {isa_d[*] isa_d_dir isa_d_oe_n}]
set_output_delay -clock clk -min 0.000 -add_delay [get_ports {isa_d[*] isa_d_dir isa_d_oe_n}]
# SPI of 1 MHz, half of it less 475 ns
set_output_delay -clock clk -max 16.667 [get_ports {spi_sclk adc_cs_n adc_din dac_sync_n dac_din dac_ldac_n}]
set_output_delay -clock clk -min 0.000 -add_delay [get_ports {spi_sclk adc_cs_n adc_din dac_sync_n dac_din dac_ldac_n}]
# off the bus with IOR#
set_max_delay -from [get_ports {isa_ior_n}] -to [get_ports {isa_d_oe_n}] 25.000
# a clock of 41 ns between what is sampled and its command
set_max_skew -from [get_ports {isa_a[*] isa_aen isa_d[*] isa_ior_n isa_iow_n}] -to [all_registers] 10.000
# The first flip-flop of each synchroniser is read by the second: rtl/lib/sync.sv
set_max_delay -from [get_registers {*|first_q*}] -to [get_registers {*|second_q*}] 10.417
