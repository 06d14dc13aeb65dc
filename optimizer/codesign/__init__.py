"""From a customer's brief to a built machine: lengths and hardware together, with a bound that none exceeds."""
