// what depends on nothing is static
asm derived_is_constant
import StandardLibrary
signature:
  controlled speed: Integer
  derived limit: Integer -> Integer //~ W007
definitions:
  function limit($load in Integer) = 10 - $load
  main rule r_Main = speed := limit(3)
