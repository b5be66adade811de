# Generated from fpga/limits.toml by fpga/limits.py; do not edit. Top: ulx3s
create_clock -name clk -period 40.000 [get_ports {clk_25mhz}]
# synchronised
set_input_delay -clock clk -max 21.667 [get_ports {ftdi_txd adc_dout enc_a[*] enc_b[*] enc_i[*] enable_n[*]}]
set_input_delay -clock clk -min 0.000 -add_delay [get_ports {ftdi_txd adc_dout enc_a[*] enc_b[*] enc_i[*] enable_n[*]}]
set_max_delay -from [get_ports {ftdi_txd adc_dout enc_a[*] enc_b[*] enc_i[*] enable_n[*]}] -to [all_registers] 20.000
# SPI of 1 MHz, half of it less 475 ns
set_output_delay -clock clk -max 16.667 [get_ports {spi_sclk adc_cs_n adc_din dac_sync_n dac_din dac_ldac_n}]
set_output_delay -clock clk -min 0.000 -add_delay [get_ports {spi_sclk adc_cs_n adc_din dac_sync_n dac_din dac_ldac_n}]
# the brakes' gate
set_max_delay -from [get_ports {estop_n}] -to [get_ports {brake_release}] 40.000
# an index and its edge in one clock of 41 ns
set_bus_skew -from [get_ports {enc_a[*] enc_b[*] enc_i[*]}] -to [all_registers] 10.000
# The first flip-flop of each synchroniser is read by the second: rtl/lib/sync.sv
set_property ASYNC_REG TRUE [get_cells -hierarchical -filter {NAME =~ */first_q_reg*}]
set_property ASYNC_REG TRUE [get_cells -hierarchical -filter {NAME =~ */second_q_reg*}]
set_max_delay -datapath_only -from [get_cells -hierarchical -filter {NAME =~ */first_q_reg*}] -to [get_cells -hierarchical -filter {NAME =~ */second_q_reg*}] 10.417
