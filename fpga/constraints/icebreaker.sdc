# Generated from fpga/limits.toml by fpga/limits.py; do not edit. Top: icebreaker
create_clock -name clk -period 83.333 [get_ports {clk_12mhz}]
# synchronised
set_input_delay -clock clk -max 85.000 [get_ports {ftdi_txd adc_dout enc_a[*] enc_b[*] enc_i[*] enable_n[*]}]
set_input_delay -clock clk -min 0.000 -add_delay [get_ports {ftdi_txd adc_dout enc_a[*] enc_b[*] enc_i[*] enable_n[*]}]
set_max_delay -from [get_ports {ftdi_txd adc_dout enc_a[*] enc_b[*] enc_i[*] enable_n[*]}] -to [all_registers] 40.000
# SPI of 1 MHz
set_output_delay -clock clk -max 85.000 [get_ports {spi_sclk adc_cs_n adc_din dac_sync_n dac_din dac_ldac_n}]
set_output_delay -clock clk -min 0.000 -add_delay [get_ports {spi_sclk adc_cs_n adc_din dac_sync_n dac_din dac_ldac_n}]
# the brakes' gate
set_max_delay -from [get_ports {estop_n}] -to [get_ports {brake_release}] 60.000
# an index and its edge in one clock of 125 ns
set_max_skew -from [get_ports {enc_a[*] enc_b[*] enc_i[*]}] -to [all_registers] 20.000
# The first flip-flop of each synchroniser is read by the second: rtl/lib/sync.sv
set_max_delay -from [get_registers {*|first_q*}] -to [get_registers {*|second_q*}] 31.250
