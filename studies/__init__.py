# SPDX-License-Identifier: Apache-2.0
"""What looks at the product from outside: measurements, comparisons, tables of the book.

May know: every room of mmcs. No room of mmcs knows it.
"""
