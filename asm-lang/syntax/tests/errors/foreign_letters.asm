asm foreign_letters
signature:
definitions:
  function größe = 1 //~ L002
