// new elements join their domain with the update set
asm extend
import StandardLibrary
signature:
  abstract domain Order
  controlled size: Order -> Integer
  controlled n: Integer
definitions:
  main rule r_Main = par
    extend Order with $a, $b do par size($a) := 1  size($b) := 2 endpar
    n := size(Order)
  endpar
//= step 1: Order + {order!1,order!2}, n := 0, size(order!1) := 1, size(order!2) := 2
//= step 2: Order + {order!3,order!4}, n := 2, size(order!3) := 1, size(order!4) := 2
