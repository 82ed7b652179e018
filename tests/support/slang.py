"""Runs slang on its arguments, as the program of that name does; exit code 1 if it finds an error."""

import sys

from pyslang.driver import CommandLineOptions, Driver

driver = Driver()
driver.addStandardArgs()
arguments = " ".join(f'"{argument}"' for argument in ["slang", *sys.argv[1:]])
good = (
    driver.parseCommandLine(arguments, CommandLineOptions())
    and driver.processOptions()
    and driver.parseAllSources()
    and driver.runFullCompilation(False)
)
sys.exit(0 if good else 1)
