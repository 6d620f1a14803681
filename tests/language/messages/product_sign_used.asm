// what follows from a misread declaration is not reported
asm product_sign_used
import StandardLibrary
signature:
  controlled at: Integer * Integer -> Integer  //~ L059
  controlled n: Integer
definitions:
  main rule r_Main = par
    at(1, 2) := 3
    n := at(1, 2)
  endpar
